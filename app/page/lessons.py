"""Lessons as files, and a page at one of their steps."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

import msgspec
from msgspec.structs import replace

from ...core.errors import InputError
from ...robot.description import Robot
from ..state import intents as do
from ..state.document import Document
from ..state.facts import Facts
from ..state.lessons import Lesson, set_screen
from ..state.on_latent import select_model
from ..state.on_models import close_model, open_model
from ..state.on_view import compare
from ..state.update import update
from .examples import examples
from .library import Library
from .uploads import Upload, read_upload

MAX_BYTES = 200_000  # of a file
MOST = 100  # files


# --- files ---
def load_lessons(folder: str | None) -> dict[str, Lesson]:
    """Those that ship, and those of a folder, by their file's name; a folder's own come first.

    Raises:
        InputError: a mistake in a file, with its line.
    """
    shipped = files("rnnpb_explorer.static") / "lessons"
    lessons = {}
    if folder is not None:
        if not Path(folder).is_dir():
            raise InputError(f"no folder {folder}")
        lessons = _read_all(Path(folder).iterdir(), f"{folder}/")
        if not lessons:
            raise InputError(f"no lessons (*.toml) in {folder}")
    return {
        **lessons,
        **{k: v for k, v in _read_all(shipped.iterdir()).items() if k not in lessons},
    }


def _read_all(found: Iterable[Traversable], where: str = "") -> dict[str, Lesson]:
    named = sorted((one for one in found if one.name.endswith(".toml")), key=lambda one: one.name)
    return {
        one.name.removesuffix(".toml"): read_lesson(one.read_bytes(), f"{where}{one.name}")
        for one in named[:MOST]
    }


def read_lesson(content: bytes, source: str) -> Lesson:
    """
    Raises:
        InputError: what is wrong in which line of `source`.
    """
    if len(content) > MAX_BYTES:
        raise InputError(f"{source} is larger than {MAX_BYTES // 1000} kB")
    try:
        text = content.decode()
        return msgspec.convert(tomllib.loads(text), Lesson)
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{source}, line {line}: not UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        what, line = _syntax(str(error), text)
        raise InputError(f"{source}, line {line}: {what}") from error
    except msgspec.ValidationError as error:
        what, _, path = str(error).partition(" - at `$")
        line = _line_of(text, path.rstrip("`"), what)
        raise InputError(f"{source}, line {line}: {what}") from error


def _syntax(said: str, text: str) -> tuple[str, int]:
    """What tomllib says, and the line that it names."""
    found = re.search(r" \(at line (\d+), column \d+\)| \(at end of document\)", said)
    assert found is not None
    return said[: found.start()], int(found[1]) if found[1] else len(text.splitlines())


def _line_of(text: str, path: str, what: str) -> int:
    """The line of what msgspec's path speaks of, `.step[2].set.goal`; its step's where none is."""
    lines = text.splitlines()
    first, last = 0, len(lines)
    step = re.match(r"\.step\[(\d+)\]", path)
    steps = [i for i, line in enumerate(lines) if re.match(r"\s*\[\[\s*step\s*\]\]", line)]
    if step is not None and int(step[1]) < len(steps):
        first = steps[int(step[1])]
        last = next((i for i in steps if i > first), last)
    unknown = re.search(r"unknown field `(.+)`", what)
    names = [unknown[1]] if unknown else list(reversed(re.findall(r"\.(\w+)", path)))
    for name in names:
        for i in range(first, last):
            if re.search(rf"(^|[.{{,\[\s]){re.escape(name)}\s*[=\]]", lines[i]):
                return i + 1
    return first + 1


# --- a page at a step ---
def at_step(
    lessons: Mapping[str, Lesson],
    library: Library,
    robot: Robot,
    document: Document,
    place: do.GoToStep,
) -> Document:
    """The document with a lesson's step on it; without one where there is no such lesson.

    Raises:
        InputError: the step cannot be shown here.
    """
    lesson = lessons.get(place.lesson)
    if lesson is None:
        return replace(document, lesson="", lesson_step=0)
    number = min(max(place.step, 0), len(lesson.step) - 1)
    setting = lesson.step[number].set

    def facts_of(document: Document) -> Facts:
        return library.facts(choice.name for choice in document.models)

    if setting.models is not None:
        document = _with_models(library, document, setting.models)
    if setting.example is not None:
        document = _with_example(facts_of(document), document, setting.example, robot)
    document = set_screen(facts_of(document), document, setting)
    return replace(document, lesson=place.lesson, lesson_step=number)


def _with_models(library: Library, document: Document, names: tuple[str, ...]) -> Document:
    """These models alone, the first one active; two are compared."""

    def facts() -> Facts:
        return library.facts(choice.name for choice in document.models)

    first, *beside = library.facts(names)
    document = open_model(facts(), document, first, beside=False)
    for other in [choice.name for choice in document.models]:
        if other not in names:
            index = [choice.name for choice in document.models].index(other)
            document = close_model(facts(), select_model(facts(), document, index))
    index = [choice.name for choice in document.models].index(first.name)
    document = select_model(facts(), document, index)
    for second in beside:
        document = open_model(facts(), document, second, beside=True)
    return document if beside else compare(facts(), document, False)


def _with_example(facts: Facts, document: Document, name: str, robot: Robot) -> Document:
    if not name:
        return update(facts, document, do.ClearTarget())
    example = next((one for one in examples() if one.name == name), None)
    if example is None:
        raise InputError(f"this step speaks of the example {name[:40]!r}, which there is not")
    one = facts[document.active]
    upload = Upload(f"{name}.csv", example.read, one)
    for intent in read_upload(upload, example.read(), robot):
        if isinstance(intent, do.SetTarget):
            joints = do.SetRecognitionOption("joints", example.observed_joints(one.joints))
            return update(facts, update(facts, document, intent), joints)
    raise InputError(f"the example {name} is none for {one.name}")
