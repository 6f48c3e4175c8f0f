"""Which joints a recognition observes: all, a part of the body, or one by one."""

from __future__ import annotations

import re
from collections.abc import Callable

import viser

from ...state import intents as do
from ...state.picture import Picture
from .bound import Bound, assign

Send = Callable[[do.Intent], None]
ALL, OTHERS = "all joints", "one by one"
# By what joints are called, on Pepper and on most other robots.
PARTS = {
    "arms": re.compile(r"shoulder|elbow|wrist|hand|arm", re.IGNORECASE),
    "left side": re.compile(r"^(L(?=[A-Z_])|left|l_)|_(l|left)(_|$)"),
    "right side": re.compile(r"^(R(?=[A-Z_])|right|r_)|_(r|right)(_|$)"),
    "head and trunk": re.compile(r"head|neck|hip|knee|torso|waist|trunk", re.IGNORECASE),
}
MOST_BOXES = 40  # joints that get a box each


def parts_of(joints: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """The parts of a body that its joints' names tell apart."""
    found = {ALL: joints}
    for part, pattern in PARTS.items():
        inside = tuple(joint for joint in joints if pattern.search(joint))
        if inside and len(inside) < len(joints):
            found[part] = inside
    return found


class JointsFolder:
    """A list of parts, and a box for each joint."""

    def __init__(self, gui: viser.GuiApi, send: Send) -> None:
        self._gui, self._send = gui, send
        self._joints: tuple[str, ...] = ()
        self._parts: dict[str, tuple[str, ...]] = {}
        self._part = Bound(gui.add_dropdown("Observed joints", [ALL]), self._choose)
        self._folder = gui.add_folder("Joints one by one", expand_by_default=False)
        self._boxes: dict[str, Bound] = {}

    def _choose(self, part: str) -> None:
        if part in self._parts:
            self._send(do.SetRecognitionOption("joints", self._parts[part]))

    def _tick(self) -> None:
        ticked = tuple(joint for joint, box in self._boxes.items() if box.handle.value)
        self._send(do.SetRecognitionOption("joints", ticked))

    def show(self, picture: Picture) -> None:
        self._build(picture.model.joints)
        observed = picture.document.recognition.joints or self._joints
        for joint, box in self._boxes.items():
            box.show(joint in observed)
        same = (part for part, joints in self._parts.items() if set(joints) == set(observed))
        part = next(same, OTHERS)
        self._part.offer([*self._parts] if part != OTHERS else [*self._parts, OTHERS])
        self._part.show(part)

    def _build(self, joints: tuple[str, ...]) -> None:
        """Boxes for the joints of the active model."""
        if joints == self._joints:
            return
        self._joints, self._parts = joints, parts_of(joints)
        for box in self._boxes.values():
            box.handle.remove()
        self._boxes = {}
        with self._folder:
            for joint in joints[:MOST_BOXES]:
                self._boxes[joint] = Bound(
                    self._gui.add_checkbox(joint, True), lambda _: self._tick()
                )
        assign(self._folder, visible=len(joints) <= MOST_BOXES)
