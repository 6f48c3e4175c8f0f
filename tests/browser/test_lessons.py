"""A lesson on a real page, from the first step to the last."""

from __future__ import annotations

import pytest
from explorer_page import Open

from rnnpb_explorer.app.page.lessons import load_lessons
from rnnpb_explorer.app.page.server import App

LESSONS = load_lessons(None)
COARSE = 0.15  # pixels of the canvas for one of the page: robots that play are slow in software


# The one with two models, morphs and ghosts; all steps of all lessons are run in the unit tests.
@pytest.mark.parametrize("name", ["2_smooth_and_rugged"])
def test_a_lesson_is_leafed_through(app: App, open_explorer: Open, name: str) -> None:
    explorer = open_explorer(app.url, resolution=COARSE)
    lesson = LESSONS[name]
    explorer.tab("Help")
    explorer.choose("Lesson", lesson.title)
    for number, step in enumerate(lesson.step, 1):
        explorer.text(f"{lesson.title} · {lesson.words.at(number, len(lesson.step))}").wait_for()
        explorer.text(step.ask).wait_for()
        if step.set.models is not None:
            robots = len(step.set.models) + bool(step.set.example)
            explorer.wait_for(f"part.robots.robots.length === {robots}")
        if number in (2, 3):
            explorer.screenshot(f"lesson-{name}-{number}")
        explorer.click(lesson.words.next)
    explorer.text(lesson.step[-1].ask).wait_for(state="hidden")


def test_back_and_undo_and_close(app: App, open_explorer: Open) -> None:
    explorer = open_explorer(app.url, resolution=COARSE)
    lesson = LESSONS["1_what_a_pb_is"]
    explorer.tab("Help")
    explorer.choose("Lesson", lesson.title)
    explorer.text(lesson.step[0].ask).wait_for()
    explorer.click("Next")
    explorer.text(lesson.step[1].ask).wait_for()
    explorer.click("Back")
    explorer.text(lesson.step[0].ask).wait_for()
    explorer.page.keyboard.press("Escape")
    explorer.press("z")
    explorer.text(lesson.step[1].ask).wait_for()
    explorer.reload(app)
    explorer.text(lesson.step[1].ask).wait_for()
    explorer.click("Close")
    explorer.text(lesson.step[1].ask).wait_for(state="hidden")
