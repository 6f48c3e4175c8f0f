"""All that one browser shows: panels, boards, robots. It writes what differs; it holds no truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Literal

import numpy as np
import viser
from msgspec import ValidationError, convert
from numpy.typing import NDArray

from ...core.windows import Landscape
from ...robot.description import Robot
from ..state import intents as do
from ..state.document import Camera, Playback, Seen, Zoom
from ..state.facts import Facts
from ..state.lessons import Lesson
from ..state.picture import Picture
from ..state.wanted import eyes_of, given_target
from .asked import Looked
from .bridge import Bridge, board_html
from .panels.explore import ExplorePanel
from .panels.help import add_help
from .panels.lesson import LessonList, LessonPart
from .panels.recognise import RecognisePanel
from .panels.robot import RobotPanel, SafetyLight
from .panels.view import ViewPanel
from .robot_nodes import eye_nodes
from .robots import ROOT, Part, RobotNames, cast_of, robots_shown
from .shown import DocumentShown, LookShown, MotionShown, PresenceShown, Shown
from .stage import FOV, camera_position, room_of, stage_for
from .views import (
    cloud_shown,
    curves_shown,
    landscape_shown,
    map_shown,
    path_shown,
    playback_shown,
    puck_shown,
    ways_shown,
)

PANEL_WIDTH = 320  # pixels
BOARDS_WIDTH = 380  # at least
BOARDS_SHARE = 0.25  # of a page's width
TWO_BOARDS_WIDTH, TWO_BOARDS_SHARE = 560, 0.44  # of two models side by side
# Five tabs in one row of so narrow a panel.
NARROW_TABS = '<style>[role="tab"] { padding-inline: 0.6em !important }</style>'
Send = Callable[[do.Intent], None]
BoardName = Literal["map", "landscape"]


class Screen:
    """Builds what one browser shows, and brings pictures on it."""

    def __init__(
        self,
        client: viser.ClientHandle,
        bridge: Bridge,
        robot: Robot,
        facts: Facts,
        offers: tuple[str, ...],
        lessons: Mapping[str, Lesson],
        send: Send,
    ) -> None:
        self._client, self._bridge, self._robot = client, bridge, robot
        self._size = room_of(robot)
        self._stage = stage_for(len(facts), *self._size)
        self._names = RobotNames(client.scene, self._size[1])
        self._send = send
        self._shown: dict[str, tuple[object, ...]] = {}  # what the page has, by kind
        self._motions = self._playbacks = 0  # sent so far
        self.played: Playback | None = None  # as the page itself has it
        # Where the page itself looks: zooms and tab, and the camera.
        self._looked = _look_of(Seen())
        self._camera: Camera | None = None
        self.heard: int | None = None  # number of the page's last move that is in the document
        self._aspect = 1.0  # of the canvas
        self._page_width = 0
        self._build_boards()
        self._build_panels(facts, offers, lessons)
        self._build_commands()

    # --- building ---
    def _build_boards(self) -> None:
        gui = self._client.gui
        self._boards = map_panel = gui.add_panel()
        landscape_panel = gui.add_panel()
        map_panel.dock_left()
        landscape_panel.dock_below(map_panel)
        map_panel.set_width(BOARDS_WIDTH)
        self._boards_width = BOARDS_WIDTH
        self._slots = 1  # pairs of boards
        self._places: dict[BoardName, viser.GuiHtmlHandle] = {}
        with map_panel.add_tab("PB map"):
            self._places["map"] = gui.add_html(board_html("map"))
        with landscape_panel.add_tab("Correlation landscape"):
            self._places["landscape"] = gui.add_html(board_html("landscape"))

    def _build_panels(
        self, facts: Facts, offers: tuple[str, ...], lessons: Mapping[str, Lesson]
    ) -> None:
        gui = self._client.gui
        gui.set_panel_label("rnnpb-explorer")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_WIDTH)
        light = SafetyLight(gui, self._robot)
        lesson = LessonPart(gui, lessons, self._send)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Explore"):
            explore = ExplorePanel(gui, facts, offers, self._send)
        with tabs.add_tab("Recognise"):
            recognise = RecognisePanel(gui, facts, self._robot, self._send)
        with tabs.add_tab("Robot"):
            robot = RobotPanel(gui, self._robot, self._send)
        with tabs.add_tab("View"):
            has_eyes = bool(eye_nodes(self._robot, ROOT))
            self._view = ViewPanel(gui, self._send, has_eyes=has_eyes)
        with tabs.add_tab("Help"):
            lesson_list = LessonList(gui, lessons, self._send)
            add_help(gui)
        gui.add_html(NARROW_TABS)
        self._panels = (light, lesson, lesson_list, explore, recognise, robot, self._view)
        self._recognise = recognise

    def _build_commands(self) -> None:
        add = self._client.gui.add_command
        for command, intent in (
            (add("Play or pause"), do.TogglePlaying()),  # Space is the browser's own
            (add("Undo", hotkey="Z"), do.Undo()),
            (add("Redo", hotkey="Y"), do.Redo()),
            (add("Random PB", hotkey="P"), do.RandomiseLatent()),
            (add("New noise", hotkey="N"), do.NewNoise()),
            (add("Back to the learned PB", hotkey="L"), do.ResetLatent()),
            (add("Reset the view", hotkey="R"), do.ResetView()),
        ):
            self._on_trigger(command, partial(self._send, intent))

    @staticmethod
    def _on_trigger(command: viser.CommandHandle, action: Callable[[], None]) -> None:
        async def triggered(event: viser.CommandEvent) -> None:
            action()

        command.on_trigger(triggered)

    # --- showing ---
    def show(self, picture: Picture) -> None:
        """Bring everything to a picture; only what differs from what stands there is written."""
        for panel in self._panels:
            panel.show(picture)
        self._show_robots(picture)
        self._show_motions(picture)
        self._show_boards(picture)
        self._show_playback(picture)

    def _show_boards(self, picture: Picture) -> None:
        document = picture.document
        self._fit_boards(len(document.on_boards))
        for slot, model in enumerate(document.on_boards):
            self._show_pair(picture.of(model), slot)
        self._put(
            "curves",
            (
                picture.model.name,
                tuple(picture.facts[index].name for index in document.on_boards),
                document.ghosts,
                document.joint,
                given_target(picture.facts, document, picture.active) or picture.reference(),
                document.recognition.observed,
                document.recognition.joints,
                document.revealed,
                picture.posterior,
                None if picture.posterior is None else picture.motion(),
            ),
            lambda: curves_shown(picture),
        )

    def _fit_boards(self, slots: int) -> None:
        """Places for the boards of one model, or of two side by side."""
        if slots == self._slots:
            return
        self._slots = slots
        for name, html in self._places.items():
            html.content = board_html(name, slots)
        self._widen()

    def _show_pair(self, picture: Picture, slot: int) -> None:
        """The two boards of one model."""
        document, latent = picture.document, picture.choice.latent
        active = (picture.active, picture.model.name, document.map_axes)
        axes = (*active, document.landscape_axes)
        run = (document.run, 0 if picture.trace is None else picture.trace.iterations)
        landscape = picture.landscape
        looks = (document.colouring, document.on_boards)
        points = (*active, *looks, latent.motion, document.added)
        self._put(f"map {slot}", points, lambda: map_shown(picture, slot))
        puck = (*axes, latent, picture.posterior, self.heard)
        self._put(f"puck {slot}", puck, lambda: puck_shown(picture, self.heard, slot))
        ways = (picture.ways(picture.active), document.walk, document.goal, latent.motion)
        self._put(f"ways {slot}", (*active, *ways), lambda: ways_shown(picture, slot))
        self._put(f"cloud {slot}", (*active, picture.belief), lambda: cloud_shown(picture, slot))
        if landscape is not None:
            what = (landscape[1], picture.landscape_complete, latent.motion, document.use_target)
            self._put(f"landscape {slot}", (*axes, *what), lambda: landscape_shown(picture, slot))
        self._put(f"path {slot}", (*axes, *run), lambda: path_shown(picture, slot))

    def _show_robots(self, picture: Picture) -> None:
        """All of them, and the camera before them."""
        cast = cast_of(picture)
        self._stage = stage_for(len(cast), *self._size)
        self._show_view(picture.document.seen)
        self._put(
            "robots",
            (*cast, *(one.joints for one in picture.facts)),
            lambda: robots_shown(self._robot, picture.facts, self._stage.robots, cast),
        )
        self._names.show(picture, self._stage.robots)

    def _show_motions(self, picture: Picture) -> None:
        checked, settings = picture.checked, picture.document.recognition
        for robot, part in enumerate(cast_of(picture)):
            model = part.model
            if part.motion == "generated":
                self._put_motion(picture, robot, part, picture.motion(model), picture.ghosts(model))
            elif part.motion == "target":
                # Cut out of the target anew for every picture: what it is follows from these.
                seen = (settings.observed, settings.joints, picture.document.revealed)
                self._put_motion(picture, robot, part, picture.seen_target, follows_from=seen)
            elif checked is not None:
                self._put_motion(picture, robot, part, checked.limited)

    def _put_motion(
        self,
        picture: Picture,
        robot: int,
        part: Part,
        motion: NDArray[np.float32] | None,
        ghosts: tuple[NDArray[np.float32], ...] = (),
        follows_from: tuple[object, ...] | None = None,
    ) -> None:
        if motion is None:
            return
        facts, document, model = picture.facts, picture.document, part.model
        generated = part.motion == "generated" and model in document.on_boards
        slot = document.on_boards.index(model) if generated else None
        if ghosts and len(ghosts[0]) != len(motion):
            ghosts = ()  # of another motion

        def shown() -> MotionShown:
            self._motions += 1
            eyes = eyes_of(facts, document, model) if document.eyes else None
            return MotionShown(
                robot,
                self._motions,
                np.nan_to_num(motion),  # what is hidden of a target's body stays at rest
                facts[model].fps,
                _rgb(eyes),
                np.stack(ghosts) if ghosts else None,
                samples=document.ghosts and document.walk is None,
                ends=part.motion == "target" and not document.revealed,
                slot=slot,
            )

        of_eyes = (facts[model].name, document.eyes, given_target(facts, document, model))
        what = (motion,) if follows_from is None else follows_from
        self._put(
            f"motion {robot}",
            (
                part,
                slot,
                *what,
                *ghosts,
                *of_eyes,
                document.walk is None,
                document.models[model].latent.motion,
            ),
            shown,
        )

    def _show_playback(self, picture: Picture) -> None:
        """What the page does not know: it plays by itself, and says what a person does there."""
        if picture.document.playback == self.played:
            return
        self.played = picture.document.playback
        self._playbacks += 1
        self._bridge.show(playback_shown(picture, self._playbacks))

    def _put(self, kind: str, what: tuple[object, ...], make: Callable[[], Shown | None]) -> None:
        if kind in self._shown and _alike(self._shown[kind], what):
            return
        self._shown[kind] = what
        shown = make()
        if shown is not None:
            self._bridge.show(shown)

    def keep(self, code: str) -> None:
        """Have the tab keep a document, which it brings back with its next hello."""
        self._bridge.show(DocumentShown(code))

    def show_presence(self, presence: PresenceShown) -> None:
        self._put("presence", (presence,), lambda: presence)

    def say(self, text: str, *, good: bool = False) -> None:
        """A line for the person, which goes away by itself."""
        self._client.add_notification(
            "rnnpb-explorer" if good else "That did not work",
            text,
            color="green" if good else "red",
            auto_close_seconds=4.0 if good else 12.0,
        )

    def show_file(self, file: do.ShowFile) -> None:
        """Offer the motions of a file that was read."""
        self._recognise.show_file(file)

    def show_code(self, code: str) -> None:
        """Write the state code where a person can copy it."""
        self._view.show_code(code)

    # --- the page's size ---
    def fold(self) -> None:
        """Fold the panels away: on a phone they would cover the boards."""
        self._client.gui.main_panel.minimize()

    def resized(self, width: int, height: int, page_width: int) -> None:
        """Page or canvas have another size: the boards get their share, robots are framed anew."""
        self._page_width = page_width
        self._widen()
        aspect = width / max(height, 1)
        if abs(aspect - self._aspect) > 0.005:  # else pixels by which panels differ
            self._aspect = aspect

    def _widen(self) -> None:
        """Give the boards their share of the page."""
        share = max(BOARDS_WIDTH, int(self._page_width * BOARDS_SHARE))
        if self._slots > 1:
            share = max(TWO_BOARDS_WIDTH, int(self._page_width * TWO_BOARDS_SHARE))
        if share != self._boards_width:  # else a person's own width stays
            self._boards_width = share
            self._boards.set_width(share)

    # --- where a person looks ---
    def looked(self, word: Looked, before: Seen) -> Seen:
        """What the document is to know of where a person looks; the page shows it already."""
        if word.turned:
            self._camera = self._camera_there()
        camera = self._camera if word.turned else before.camera
        front = self._front()
        if camera is not None and np.allclose(_numbers(camera), _numbers(front), atol=1e-3):
            camera, self._camera = None, front
        seen = Seen(word.map, word.landscape, word.map_2, word.landscape_2, camera, word.tab)
        self._looked = _look_of(seen)
        return seen

    def _show_view(self, seen: Seen) -> None:
        """The boards, the tab and the camera as they were looked at."""
        look = _look_of(seen)
        if look != self._looked:
            self._looked = look
            self._bridge.show(LookShown(*look))
        here = seen.camera or self._front()
        if here == self._camera:
            return
        self._camera = here
        camera = self._client.camera
        with self._client.atomic():
            camera.fov = FOV
            camera.position = np.array(here.position)
            camera.look_at = np.array(here.look_at)
            camera.up_direction = (0.0, 0.0, 1.0)

    def _front(self) -> Camera:
        """Before everything, as far away as the canvas's shape asks for."""
        x, y, z = self._stage.middle.tolist()
        return Camera(tuple(camera_position(self._stage, self._aspect).tolist()), (x, y, z))

    def _camera_there(self) -> Camera | None:
        """Where a person has turned the camera to; None where nobody can be."""
        there = self._client.camera
        try:
            return convert(
                {"position": there.position.tolist(), "look_at": there.look_at.tolist()}, Camera
            )
        except ValidationError:
            return None


def _look_of(seen: Seen) -> tuple[Zoom | None, Zoom | None, Zoom | None, Zoom | None, str]:
    return seen.map, seen.landscape, seen.map_2, seen.landscape_2, seen.tab


def _numbers(camera: Camera) -> tuple[float, ...]:
    return (*camera.position, *camera.look_at)


def _rgb(eyes: NDArray[np.float32] | None) -> NDArray[np.uint8] | None:
    """(T, 3 * segments) of (T, 2, 8, 3) from 0 to 1."""
    if eyes is None:
        return None
    rgb: NDArray[np.uint8] = (eyes * 255).round().astype(np.uint8).reshape(len(eyes), -1)
    return rgb


def _alike(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    """Whether values are equal; results are the same ones or others, whatever is in them."""
    return len(one) == len(other) and all(
        a is b or (not _is_result(a) and not _is_result(b) and a == b)
        for a, b in zip(one, other, strict=True)
    )


def _is_result(value: object) -> bool:
    return isinstance(value, np.ndarray | Landscape)
