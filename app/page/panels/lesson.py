"""A lesson above the tabs: where one is, what one sees, what to try, and the buttons."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import viser

from ...state import intents as do
from ...state.lessons import Lesson
from ...state.picture import Picture
from .bound import Bound, assign, on_click
from .text import paragraphs, write

Send = Callable[[do.Intent], None]

NONE = "none"


class LessonPart:
    """The step of the lesson that the document is at; nothing where there is none."""

    def __init__(self, gui: viser.GuiApi, lessons: Mapping[str, Lesson], send: Send) -> None:
        self._lessons, self._send = lessons, send
        self._at = do.GoToStep("", 0)
        self._text = gui.add_html("")
        self._buttons = gui.add_button_group("", ("Back", "Next", "Close"), visible=False)
        on_click(self._buttons, self._go)

    def _go(self) -> None:
        lesson = self._lessons.get(self._at.lesson)
        if lesson is None:
            return
        pressed, step = self._buttons.value, self._at.step
        over = pressed == lesson.words.next and step + 1 == len(lesson.step)
        if pressed == lesson.words.close or over:
            self._send(do.GoToStep("", 0))
        else:
            way = 1 if pressed == lesson.words.next else -1
            self._send(do.GoToStep(self._at.lesson, max(step + way, 0)))

    def show(self, picture: Picture) -> None:
        document = picture.document
        lesson = self._lessons.get(document.lesson)
        assign(self._buttons, visible=lesson is not None)
        if lesson is None:
            write(self._text, "")
            return
        number = min(document.lesson_step, len(lesson.step) - 1)
        self._at = do.GoToStep(document.lesson, number)
        step, words = lesson.step[number], lesson.words
        assign(self._buttons, options=(words.back, words.next, words.close))
        where = f"{lesson.title} · {words.at(number + 1, len(lesson.step))}"
        write(self._text, paragraphs(where, step.say, step.ask))


class LessonList:
    """All lessons, to choose one."""

    def __init__(self, gui: viser.GuiApi, lessons: Mapping[str, Lesson], send: Send) -> None:
        titles = [lesson.title for lesson in lessons.values()]
        self._names = dict(zip(titles, lessons, strict=True))
        self._list = Bound(
            gui.add_dropdown("Lesson", [NONE, *titles], hint="a few steps, one prompt each"),
            lambda title: send(do.GoToStep(self._names.get(title, ""), 0)),
        )

    def show(self, picture: Picture) -> None:
        lesson = picture.document.lesson
        self._list.show(
            next((title for title, name in self._names.items() if name == lesson), NONE)
        )
