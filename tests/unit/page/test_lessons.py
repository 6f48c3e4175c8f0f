"""Lessons: what a file may say, where a mistake is, and what each step makes of the screen."""

from __future__ import annotations

from pathlib import Path

import pytest

from rnnpb_explorer.app.page.lessons import at_step, load_lessons, read_lesson
from rnnpb_explorer.app.page.library import Library
from rnnpb_explorer.app.page.server import ServerOptions, open_library, opening
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import Document
from rnnpb_explorer.app.state.lessons import Lesson
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.robot.description import Robot, load_robot

LINES = (
    'title = "A lesson"',  # 1
    "[words]",
    'back = "Zurück"',
    'next = "Weiter"',
    'close = "Schließen"',  # 5
    'step = "Schritt {step} von {steps}"',
    "[[step]]",
    'say = "Here it is."',
    'ask = "What is it?"',
    'set = { models = ["strong"], motion = "Happy_4" }',  # 10
    "[[step]]",
    'say = "There it goes."',
    'ask = "Where?"',
    "[step.set]",
    "observed = 0.5",  # 15
    'tab = "Recognise"',
)


def lines_with(number: int, line: str) -> bytes:
    """The lesson with another line in one place, from 1."""
    lines = [line if i == number else old for i, old in enumerate(LINES, 1)]
    return "\n".join(lines).encode()


def test_all_that_a_person_reads_stands_in_the_file() -> None:
    lesson = read_lesson("\n".join(LINES).encode(), "mine.toml")
    assert lesson.title == "A lesson"
    assert lesson.words.at(1, 2) == "Schritt 1 von 2"
    assert [step.ask for step in lesson.step] == ["What is it?", "Where?"]
    assert lesson.step[1].set.observed == 0.5


@pytest.mark.parametrize(
    ("number", "line", "said"),
    [
        (1, "title = 3", "Expected `str`, got `int`"),
        (3, "back = Zurück", "Invalid value"),
        (3, "", "missing required field `back`"),
        (4, 'next = "Zurück"', "have to differ"),
        (6, 'step = "{where}"', "can stand in braces"),
        (9, "", "missing required field `ask`"),
        (10, 'set = { models = ["strong"], motoin = "Happy_4" }', "unknown field `motoin`"),
        (10, "set = { sigma = -1 }", ">= 0"),
        (12, 'say = ""', "length >= 1"),
        (15, "observed = 7", "<= 1"),
        (16, 'tab = "Nowhere"', "Invalid enum value"),
        (16, 'tab = "Recognise', ""),
    ],
)
def test_a_mistake_names_its_line(number: int, line: str, said: str) -> None:
    at = {3: 2 if not line else 3, 4: 2, 6: 2, 9: 7 if not line else 9}.get(number, number)
    with pytest.raises(InputError, match=rf"^mine\.toml, line {at}: ") as refused:
        read_lesson(lines_with(number, line), "mine.toml")
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [b"\xff", b"", b"x" * 300_000, b"[[step]]"])
def test_what_is_no_lesson_costs_one_line(content: bytes) -> None:
    with pytest.raises(InputError, match=r"mine\.toml") as refused:
        read_lesson(content, "mine.toml")
    assert "\n" not in str(refused.value)


def test_a_folder_of_ones_own_comes_first(tmp_path: Path) -> None:
    (tmp_path / "9_mine.toml").write_bytes("\n".join(LINES).encode())
    (tmp_path / "notes.txt").write_text("no lesson")
    assert list(load_lessons(str(tmp_path))) == ["9_mine", *load_lessons(None)]
    (tmp_path / "9_mine.toml").write_bytes(lines_with(15, "observed = 7"))
    with pytest.raises(InputError, match=r"9_mine\.toml, line 15: "):
        load_lessons(str(tmp_path))
    with pytest.raises(InputError, match="no folder"):
        load_lessons(str(tmp_path / "nowhere"))
    (tmp_path / "9_mine.toml").unlink()
    with pytest.raises(InputError, match="no lessons"):
        load_lessons(str(tmp_path))


# --- a page at a step ---
LESSONS = load_lessons(None)
STEPS = [(name, step) for name, one in LESSONS.items() for step in range(len(one.step))]


@pytest.fixture(scope="module")
def library() -> Library:
    return open_library(ServerOptions(checkpoints=("weak",)))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("pepper")


def fresh(library: Library) -> Document:
    return opening(library, ServerOptions(checkpoints=("weak",)))


def test_there_are_three() -> None:
    titles = [one.title for one in LESSONS.values()]
    assert titles == ["What a PB is", "Smooth and rugged", "Recognition as a belief that moves"]


@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_runs_from_its_first_step_to_its_last(
    library: Library, robot: Robot, name: str
) -> None:
    document = fresh(library)
    for number, step in enumerate(LESSONS[name].step):
        document = at_step(LESSONS, library, robot, document, do.GoToStep(name, number))
        check_set(document, LESSONS[name], name, number)
        facts = library.facts(choice.name for choice in document.models)
        if step.set.motion is not None:
            known = facts[document.active].motions
            assert known[document.current.latent.motion] == step.set.motion
    document = at_step(LESSONS, library, robot, document, do.GoToStep("", 0))
    assert (document.lesson, document.lesson_step) == ("", 0)


@pytest.mark.parametrize(("name", "number"), STEPS)
def test_all_steps_but_what_they_go_on_from_can_be_come_back_to(
    library: Library, robot: Robot, name: str, number: int
) -> None:
    """Over the lesson's first step, as a person who opens it and leafs through it."""
    document = fresh(library)
    for place in (0, len(LESSONS[name].step) - 1, number):
        document = at_step(LESSONS, library, robot, document, do.GoToStep(name, place))
    check_set(document, LESSONS[name], name, number)


def check_set(document: Document, lesson: Lesson, name: str, number: int) -> None:
    wanted = lesson.step[number].set
    assert (document.lesson, document.lesson_step) == (name, number)
    if wanted.models is not None:
        assert [choice.name for choice in document.models] == list(wanted.models)
        assert document.compare == (len(wanted.models) > 1)
    for field in ("goal", "hand", "window", "ghosts", "joint", "revealed"):
        if getattr(wanted, field) is not None:
            assert getattr(document, field) == getattr(wanted, field), field
    if wanted.walk is not None:
        assert document.walk == (None if wanted.walk == "no" else wanted.walk)
    for field in ("method", "observed", "slow"):
        if getattr(wanted, field) is not None:
            assert getattr(document.recognition, field) == getattr(wanted, field), field
    if wanted.sigma is not None:
        assert set(document.current.latent.sigma) == {wanted.sigma}
    if wanted.example is not None:
        assert (document.target.name if document.target else "") == wanted.example
    if wanted.recognise:
        assert document.running
    if wanted.playing is not None:
        assert document.playback.playing == wanted.playing
    if wanted.tab is not None:
        assert document.seen.tab == (wanted.tab if wanted.tab != "Explore" else "")


def test_a_step_that_cannot_be_shown_says_why(library: Library, robot: Robot) -> None:
    for old, new, said in (
        ("Happy_4", "Handstand", "Handstand, which strong does not know"),
        ('models = ["strong"]', 'models = ["nope"]', "no model 'nope' here"),
        ('motion = "Happy_4"', 'example = "none"', "example 'none', which there is not"),
    ):
        content = "\n".join(LINES).replace(old, new).encode()
        lessons = {"mine": read_lesson(content, "mine.toml")}
        with pytest.raises(InputError, match=said):
            at_step(lessons, library, robot, fresh(library), do.GoToStep("mine", 0))


def test_a_lesson_that_is_not_here_is_none(library: Library, robot: Robot) -> None:
    """A state code of another server may name one."""
    document = at_step({}, library, robot, fresh(library), do.GoToStep("theirs", 2))
    assert document.lesson == ""
