"""The browser's part with a small server behind it, in a process of its own.

It shows Pepper, the map and the landscape of `strong.pt`, answers moves as the app does, and writes
every message that the page sends to its standard output, one JSON line each. The first line says
the port. A line on its standard input is done on the page: see `Demo.command`.

    python tests/browser/web_demo.py
"""

from __future__ import annotations

import argparse
import json
import queue
import sys
import threading
import time
from collections.abc import Sequence

import msgspec
import numpy as np
import torch
import viser
from numpy.typing import NDArray

from rnnpb_explorer.app.page import asked as do
from rnnpb_explorer.app.page.bridge import Bridge, board_html
from rnnpb_explorer.app.page.robot_nodes import add_robot, robot_shown
from rnnpb_explorer.app.page.shown import (
    CurvesShown,
    DocumentShown,
    LandscapeShown,
    MapShown,
    MotionShown,
    PathShown,
    PlaybackShown,
    PuckShown,
    RobotsShown,
)
from rnnpb_explorer.core import load_checkpoint
from rnnpb_explorer.core.correlation import Landscape, landscape_stages
from rnnpb_explorer.core.latent_map import LatentMap
from rnnpb_explorer.robot.description import load_robot

Array = NDArray[np.float64]
FOV = 0.5
ROOT = "/robot"
MOTION = 0
FRAMES = 140
AXES, HIDDEN = (0, 1), (2, 3)
GHOSTS = 8
SAID = sys.stdout  # ours alone; viser's own lines go to the terminal


class Session:
    """One page: applies what it asks, one after the other, on a thread of its own."""

    def __init__(self, demo: Demo, client: viser.ClientHandle) -> None:
        self.demo, self.client = demo, client
        self.asked: queue.Queue[do.AnyAsked | None] = queue.Queue()
        self.motion, self.mu = MOTION, demo.mu[MOTION].copy()
        self.heard = self.number = 0
        self.colouring = "class"
        self.observed = 0.8
        self.sigma = demo.sigma[MOTION].copy()
        self.ghosts = False
        self.dark = False
        self.panels: list[viser.PanelHandle] = []
        for k, board in enumerate(("map", "landscape")):
            panel = client.gui.add_panel()
            if k == 0:
                panel.dock_left()
                first = panel
            else:
                panel.dock_below(first)
            self.panels.append(panel)
            panel.set_width(380)
            tab = panel.add_tab("Map" if k == 0 else "Landscape")
            with tab:
                client.gui.add_html(board_html(board))
            if k == 0:
                self.map_tab = tab
                panel.add_tab("Other tab")
        client.gui.add_text("Note", "")
        client.gui.add_button("Other button")
        client.gui.main_panel.dock_right()
        self.bridge = Bridge(client, self.hear)
        threading.Thread(target=self.run, daemon=True).start()

    def hear(self, asked: do.AnyAsked) -> None:
        self.demo.say({"page": self.client.client_id, **msgspec.to_builtins(asked)})
        self.asked.put(asked)

    def run(self) -> None:
        while True:
            try:
                asked = self.asked.get(timeout=0.15)
            except queue.Empty:
                if self.stale:
                    self.stale = False
                    self.show_landscape()
                continue
            if asked is None:
                return
            self.apply(asked)

    stale = False

    def apply(self, asked: do.AnyAsked) -> None:
        demo = self.demo
        match asked:
            case do.Hello():
                if asked.document:
                    kept = json.loads(asked.document)
                    self.motion, self.mu = kept["motion"], np.array(kept["mu"])
                for panel in self.panels:
                    panel.set_width(max(380, round(0.24 * asked.page_width)))
                self.frame_camera(asked.width / max(asked.height, 1))
                self.show_all()
                return
            case do.Resized():
                self.frame_camera(asked.width / max(asked.height, 1))
                return
            case do.MoveOnMap():
                self.mu = demo.map.move(self.mu, asked.axes, asked.to)
                self.heard = asked.number
            case do.MoveOnLandscape():
                self.mu[: len(asked.to)] = asked.to
                self.heard = asked.number
            case do.SelectMotion():
                self.motion, self.mu = asked.index, demo.mu[asked.index].copy()
                self.sigma = demo.sigma[asked.index].copy()
                self.show_map()
            case do.SetObserved():
                self.observed = asked.share
                return
            case _:
                return
        self.show_puck()
        if self.asked.empty():
            self.show_motion()
        self.stale = True
        self.bridge.show(DocumentShown(json.dumps({"motion": self.motion, "mu": self.mu.tolist()})))

    def frame_camera(self, aspect: float) -> None:
        half = 0.66
        distance = 1.06 * half / np.tan(FOV / 2) / min(aspect / 0.95, 1.0)
        camera = self.client.camera
        camera.fov = FOV
        camera.position = (distance * 0.97, 0.24 * distance, 0.62 + 0.07 * distance)
        camera.look_at = (0.0, 0.0, 0.58)

    # --- showing ---
    def show_all(self) -> None:
        robots = [robot_shown(self.demo.robot, self.demo.joints, ROOT)]
        if self.demo.two:
            robots.append(
                robot_shown(
                    self.demo.robot, self.demo.joints, ROOT, spot=(0.0, 0.95, 0.0), copy_of=0
                )
            )
        self.bridge.show(RobotsShown(tuple(robots)))
        self.show_map()
        self.show_puck()
        self.show_motion()
        self.bridge.show(PlaybackShown(0, playing=False, frame=40, speed=1.0, loop=True))
        self.show_landscape()

    def show_map(self) -> None:
        demo = self.demo
        labels = [demo.labels[name] for name in demo.names]
        values = None
        if self.colouring != "class":
            values = np.array([getattr(one, self.colouring) for one in labels], dtype=np.float64)
        points = demo.map.points[:, list(AXES)]
        low, high = points.min(axis=0), points.max(axis=0)
        pad = 0.12 * (high - low)
        self.bridge.show(
            MapShown(
                model=0,
                title="strong",
                axes=AXES,
                hidden_axes=HIDDEN,
                axis_labels=tuple(f"PC {i + 1}" for i in (*AXES, *HIDDEN)),
                points=points,
                names=demo.names,
                colouring=self.colouring,
                classes=tuple(one.behavior_class for one in labels),
                values=values,
                selected=self.motion,
                extent=np.array([low[0], high[0], low[1], high[1]])
                + np.array([-1, 1, -1, 1]) * np.repeat(pad, 2),
                pairs=1,
                added=low[None],  # in a corner, where nothing was learnt
                added_names=("mine",),
                added_index=np.array([4]),
            )
        )

    def show_puck(self) -> None:
        latent_map = self.demo.map
        at = latent_map.project(self.mu)
        self.bridge.show(
            PuckShown(
                on_map=at[list(AXES)],
                on_landscape=self.mu[:2],
                hidden=at[list(HIDDEN)],
                covariance=latent_map.ellipse(self.sigma, AXES),
                off_plane=latent_map.off_plane(self.mu, AXES),
                extrapolation=latent_map.extrapolation(self.mu),
                heard=self.heard,
            )
        )

    def show_motion(self) -> None:
        demo = self.demo
        angles = demo.generate(self.mu[None])[0]
        ghosts = demo.generate(self.mu + self.sigma * demo.noise) if self.ghosts else None
        self.number += 1
        eyes = np.tile(np.arange(48, dtype=np.uint8) * 5, (FRAMES, 1)) if demo.eyes else None
        self.bridge.show(
            MotionShown(0, self.number, angles, 25.0, eyes, ghosts, samples=True, slot=0)
        )
        if demo.two:
            self.bridge.show(
                MotionShown(1, self.number, demo.generate(demo.mu[[3]])[0], 25.0, eyes)
            )
        reference = demo.generate(demo.mu[[self.motion]])[0]
        self.bridge.show(
            CurvesShown(
                demo.joints,
                ("demo",),
                np.arange(len(demo.joints))[None],
                joint=2,
                reference=reference,
                observed=self.observed,
            )
        )

    def show_landscape(self) -> None:
        demo = self.demo
        target = demo.generate(demo.mu[[self.motion]])[0]
        center = demo.mu[self.motion]
        for stage in landscape_stages(demo.model, target, center):
            self.bridge.show(self.landscape(stage, center))
            if not self.asked.empty():
                self.stale = True
                return

    def landscape(self, stage: Landscape, center: Array) -> LandscapeShown:
        half = (stage.x[1] - stage.x[0]) / 2
        inside = np.flatnonzero((np.abs(self.demo.mu[:, :2] - center[:2]) <= 1).all(axis=1))
        return LandscapeShown(
            model=0,
            correlation=stage.correlation,
            x=stage.x,
            y=stage.y,
            extent=np.array(
                [stage.x[0] - half, stage.x[-1] + half, stage.y[0] - half, stage.y[-1] + half]
            ),
            complete=stage.complete,
            axis_labels=("μ 1", "μ 2"),
            window="±1 around the motion",
            target="its reconstruction",
            mean=stage.mean,
            area=stage.area,
            roughness=stage.roughness,
            learned=self.demo.mu[inside, :2],
            learned_index=inside,
        )

    def show_path(self) -> None:
        rng = np.random.default_rng(0)
        steps = np.linspace(0, 1, 40)[:, None]
        way = (1 - steps) * np.array([1.5, -2.0, 0, 0]) + steps * self.mu
        way += 0.12 * (1 - steps) * rng.standard_normal(way.shape)
        samples = way + 0.25 * (1.05 - steps) * rng.standard_normal(way.shape)
        project = self.demo.map.project
        self.bridge.show(
            PathShown(
                on_map=project(way)[:, list(AXES)],
                on_landscape=way[:, :2],
                radii=np.geomspace(1.0, 0.1, 40),
                samples_on_map=project(samples)[:, list(AXES)],
                samples_on_landscape=samples[:, :2],
                shown=32,
            )
        )


class Demo:
    """The server and what all its pages share."""

    def __init__(self, two: bool = False, eyes: bool = False, port: int = 0) -> None:
        torch.set_num_threads(1)
        self.model = load_checkpoint("strong")
        self.mu = self.model.mu.detach().numpy().astype(np.float64)
        self.sigma = self.model.sigma.detach().numpy().astype(np.float64)
        self.map = LatentMap.fit(self.mu)
        self.names = tuple(self.model.info.motions)
        self.labels = self.model.info.labels
        self.joints = tuple(self.model.info.joints)
        self.noise = np.random.default_rng(0).standard_normal((GHOSTS, self.mu.shape[1]))
        self.robot = load_robot("pepper")
        self.two, self.eyes = two, eyes
        self.sessions: list[Session] = []
        self.server = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
        self.server.scene.configure_environment_map(None)
        self.server.scene.add_grid("/floor", width=4, height=4, cell_size=0.25, section_size=1.0)
        add_robot(self.server.scene, self.robot, ROOT)

        @self.server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            self.sessions.append(Session(self, client))

        self.say({"port": self.server.get_port()})

    def generate(self, pb: Array) -> NDArray[np.float32]:
        """(B, T, J)"""
        with torch.inference_mode():
            motion: NDArray[np.float32] = self.model.generate(
                torch.as_tensor(pb, dtype=torch.float32), FRAMES
            ).numpy()
        return motion

    def command(self, name: str, arguments: Sequence[str]) -> None:
        """Do something on the newest page."""
        session = self.sessions[-1]
        match name:
            case "colour":
                session.colouring = arguments[0]
                session.show_map()
            case "path":
                session.show_path()
            case "ghosts":
                session.ghosts = arguments[0] == "on"
                session.show_motion()
            case "dark":
                session.client.gui.configure_theme(dark_mode=arguments[0] == "on")
            case "refused":
                self.say({"refused": session.bridge.refused})
            case "sibling":
                with session.map_tab:
                    session.client.gui.add_markdown("Another")
            case "line":
                x = np.linspace(-1, 1, 20)
                session.bridge.show(
                    LandscapeShown(
                        model=0,
                        correlation=np.cos(2 * x)[None].astype(np.float32),
                        x=x,
                        y=np.zeros(1),
                        extent=np.array([-1.05, 1.05, -0.5, 0.5]),
                        complete=True,
                        axis_labels=("μ 1",),
                        window="±1",
                        target="its reconstruction",
                        mean=0.5,
                        area=0.3,
                        roughness=0.02,
                    )
                )

    def say(self, line: dict[str, object]) -> None:
        print(json.dumps({"time": time.monotonic(), **line}), file=SAID, flush=True)


def main() -> None:
    sys.stdout = sys.stderr
    options = argparse.ArgumentParser()
    options.add_argument("--two", action="store_true", help="a second robot")
    options.add_argument("--eyes", action="store_true", help="eye colours")
    options.add_argument("--port", type=int, default=0)
    demo = Demo(**vars(options.parse_args()))
    for line in sys.stdin:
        name, *arguments = line.split()
        demo.command(name, arguments)
    demo.server.stop()


if __name__ == "__main__":
    main()
