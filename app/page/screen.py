"""All that one browser shows: robots, boards, panels. It writes handles; it holds no truth."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import viser
from numpy.typing import NDArray

from ...robot.description import Robot
from ...robot.kinematics import size
from ..state import intents as do
from ..state.picture import Picture
from .boards.landscape_view import LandscapeView
from .boards.map_view import MapView
from .panels.explore import ExplorePanel
from .panels.help import add_help
from .panels.joints import JointsPanel
from .panels.playback import PlaybackPanel
from .panels.readout import ReadoutPanel
from .panels.recognise import RecognisePanel
from .panels.robot import RobotPanel, SafetyLight
from .panels.view import ViewPanel
from .robots import Robots
from .stage import FOV, camera_position, stage_for
from .studio import setup_stage

PANEL_WIDTH = 320  # pixels
# Six tabs in one row of so narrow a panel.
NARROW_TABS = '<style>[role="tab"] { padding-inline: 0.6em !important }</style>'
Send = Callable[[do.Intent], None]


class Screen:
    """Builds the scene and the panels of one browser, and shows states on them."""

    def __init__(
        self,
        client: viser.ClientHandle,
        robot: Robot,
        picture: Picture,
        send: Send,
    ) -> None:
        self._client, self._facts, self._robot = client, picture.facts, robot
        self._size = size(robot)  # half width, height
        self._stage = stage_for(len(picture.facts), *self._size)
        self._send = send
        self._home: tuple[float, NDArray[np.float64]] | None = None  # aspect, position
        self._build_scene(picture)
        self._build_panels()
        self._build_commands()
        client.camera.on_update(self._camera_moved)
        self.reset_view()

    # --- building ---
    def _build_scene(self, picture: Picture) -> None:
        scene = self._client.scene
        setup_stage(scene)
        spots = stage_for(len(self._facts) + 1, *self._size).robots
        self.robots = Robots(scene, self._robot, self._facts, spots, self._size[1])
        self.map_board = MapView(scene, self._stage.map_board, picture, self._send)
        self.landscape_board = LandscapeView(
            scene, self._stage.landscape_board, picture, self._send
        )

    def _build_panels(self) -> None:
        gui = self._client.gui
        gui.set_panel_label("rnnpb-explorer")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL_WIDTH)
        with gui.add_folder("Playback"):
            playback = PlaybackPanel(gui, self._send)
            light = SafetyLight(gui, self._facts, self._robot)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Explore"):
            explore = ExplorePanel(gui, self._facts, self._send)
            readout = ReadoutPanel(gui)
        with tabs.add_tab("Joints"):
            joints = JointsPanel(gui, self._facts[0].joints, self._send)
        with tabs.add_tab("Recognise"):
            recognise = RecognisePanel(gui, self._facts, self._send)
        with tabs.add_tab("Robot"):
            robot = RobotPanel(gui, self._facts, self._robot, self._send)
        with tabs.add_tab("View"):
            self._view = ViewPanel(gui, self._send, has_eyes=self.robots.have_eyes)
        with tabs.add_tab("Help"):
            add_help(gui)
        gui.add_html(NARROW_TABS)
        self._panels = (playback, light, explore, readout, joints, recognise, robot, self._view)

    def _build_commands(self) -> None:
        add = self._client.gui.add_command
        send = self._send
        for command, action in (
            (add("Play or pause", hotkey="space"), partial(send, do.TogglePlaying())),
            (add("Undo", hotkey="Z"), partial(send, do.Undo())),
            (add("Redo", hotkey="Y"), partial(send, do.Redo())),
            (add("Random PB", hotkey="P"), partial(send, do.RandomiseLatent())),
            (add("New noise", hotkey="N"), partial(send, do.NewNoise())),
            (add("Back to the learned PB", hotkey="L"), partial(send, do.ResetLatent())),
            (add("Reset the view", hotkey="R"), partial(send, do.ResetView())),
        ):
            self._on_trigger(command, action)

    @staticmethod
    def _on_trigger(command: viser.CommandHandle, action: Callable[[], None]) -> None:
        async def triggered(event: viser.CommandEvent) -> None:
            action()

        command.on_trigger(triggered)

    # --- showing ---
    def show(self, picture: Picture) -> None:
        """Bring everything to a picture; only what differs from what stands there is written."""
        with self._client.atomic():
            self.robots.show(picture)
            self.map_board.show(picture)
            self.landscape_board.show(picture)
        for panel in self._panels:
            panel.show(picture)
        self._fit(picture)

    def _fit(self, picture: Picture) -> None:
        """Have the camera see all robots, where there are more or fewer than before."""
        robots = len(picture.facts) + picture.document.side_by_side
        if robots != len(self._stage.robots):
            self._stage = stage_for(robots, *self._size)
            self.reset_view()

    def say(self, text: str, *, good: bool = False) -> None:
        """A line for the person, which goes away by itself."""
        self._client.add_notification(
            "rnnpb-explorer" if good else "That did not work",
            text,
            color="green" if good else "red",
            auto_close_seconds=4.0 if good else 12.0,
        )

    def show_code(self, code: str) -> None:
        """Write the state code where a person can copy it."""
        self._view.show_code(code)

    # --- the camera ---
    async def _camera_moved(self, camera: viser.CameraHandle) -> None:
        """A window that changes its shape shows everything again, if it did so before."""
        if self._home is None:
            return
        aspect, position = self._home
        at_home = np.allclose(camera.position, position, atol=0.02)
        if at_home and abs(camera.aspect - aspect) > 0.005:
            self._send(do.ResetView())

    def reset_view(self) -> None:
        """Look at everything from the front, from as far as the window's shape asks for."""
        camera = self._client.camera
        position = camera_position(self._stage, camera.aspect)
        self._home = (camera.aspect, position)
        with self._client.atomic():
            camera.fov = FOV
            camera.position = position
            camera.look_at = self._stage.middle
            camera.up_direction = (0.0, 0.0, 1.0)
