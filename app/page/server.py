"""The server: loads the models once, and opens a session for every browser that comes."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import socket
import threading
import warnings
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
import viser
from msgspec.structs import replace

from ...core.checkpoint import load_checkpoint
from ...core.data import Dataset
from ...core.device import choose_device
from ...core.errors import InputError
from ...core.latent_map import LatentMap
from ...core.model import RNNPB, UNKNOWN_LENGTH
from ...robot.data import load_dataset
from ...robot.description import Robot, load_robot, match_joints
from ...robot.eyes import load_eyes
from ...robot.reading import NOTHING_SAID, Said
from ..engine.engine import Engine
from ..state import intents as do
from ..state.document import Document, EyeTrack
from ..state.facts import Facts, ModelFacts
from ..state.opening import opening_document
from ..state.statecode import decode
from ..state.wanted import motion_steps
from .door import WILDCARDS, address_for_others, make_door, url_host
from .gate import FileTransferStartUpload
from .guard import Guard, page_scripts
from .robot_nodes import add_robot
from .robots import ROOT
from .session import Session
from .stage import staged
from .studio import set_up_studio
from .uploads import TOO_LARGE
from .words import none_matches

MAX_MODELS = 4
MAX_SESSIONS = 64  # pages open at once; each has threads and a screen of its own
MOST_REMARKS = 8  # on the robot, in the log
STOP_SECONDS = 5.0  # that a session's threads get to end when the server stops
FULL = "This server shows {} pages already, as many as it takes. Close one and reload this page."
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServerOptions:
    """What the command line decides."""

    checkpoints: tuple[str, ...] = ("strong.pt",)
    host: str = "127.0.0.1"
    port: int = 8080  # 0: any free one
    token: str | None = None  # without it no page and no session
    no_token: bool = False  # said to be meant: everybody who reaches the host may come in
    allow_origins: tuple[str, ...] = ()  # where a proxy shows the page
    allow_frames: tuple[str, ...] = ()  # sites that may embed it
    robot: str = "pepper"
    data: str | None = None
    said: Said = NOTHING_SAID  # of the data's files
    device: str = "auto"
    seed: int = 0
    motion: str | None = None  # to open with, of the first model
    frame: int | None = None  # to open at, paused
    state_code: str | None = None


class App:
    """The running server."""

    def __init__(self, options: ServerOptions) -> None:
        door = make_door(
            options.host,
            token=options.token,
            no_token=options.no_token,
            allow_origins=options.allow_origins,
            allow_frames=options.allow_frames,
            scripts=page_scripts(),
        )
        models = load_models(options)
        self.robot = load_robot(options.robot)
        self.facts = describe_models(models, options)
        for warning in (*unmatched_joints(self.robot, self.facts), *remarks(self.robot)):
            log.warning("%s", warning)
        self.opening = opening(self.facts, models[0], options)
        self._lock = threading.Lock()
        self.sessions: dict[int, Session] = {}
        guard = Guard(door)
        guard.too_large = self._refuse_upload
        self._server = serve(options, guard)
        set_up_studio(self._server.scene)
        self._staged = staged(self.robot)
        add_robot(self._server.scene, self._staged, ROOT)
        self._engine = Engine(models, [one.data for one in self.facts], self.robot)
        self._server.on_client_connect(self._connected)
        self._server.on_client_disconnect(self._disconnected)
        self.url = f"http://{url_host(options.host)}:{self._server.get_port()}"
        self.link = door.link(self.url)  # with the token in it
        others = address_for_others() if options.host in WILDCARDS else None
        self.link_for_others = (
            None if others is None else door.link(f"http://{others}:{self._server.get_port()}")
        )

    def stop(self) -> None:
        """End every session and the server."""
        with self._lock:
            sessions = list(self.sessions.values())
            self.sessions.clear()
        for session in sessions:
            session.close()
        for session in sessions:
            session.join(STOP_SECONDS)
        self._engine.close(STOP_SECONDS)
        with contextlib.redirect_stdout(io.StringIO()):  # viser says so in a line of its own
            self._server.stop()

    # viser runs these two on threads of its own.
    def _connected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            full = len(self.sessions) >= MAX_SESSIONS
            if not full:
                self.sessions[client.client_id] = Session(
                    client,
                    self.facts,
                    self._engine,
                    self._staged,
                    self.opening,
                    partial(self._disconnected, client),
                )
        if full:
            log.warning("a browser was refused: there are %d pages", MAX_SESSIONS)
            client.gui.add_markdown(FULL.format(MAX_SESSIONS))
        if client.client_id not in self._server.get_clients():
            self._disconnected(client)  # it went before there was a session to close

    def _disconnected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    # viser's event loop: only hand on.
    def _refuse_upload(self, client_id: int, upload: FileTransferStartUpload) -> None:
        session = self.sessions.get(client_id)
        if session is not None:
            session.send(do.Say(TOO_LARGE))


def start(options: ServerOptions) -> App:
    """Load everything and serve.

    Raises:
        InputError: a checkpoint, robot, data, motion or port that cannot be had.
    """
    return App(options)


def load_models(options: ServerOptions) -> tuple[RNNPB, ...]:
    if not 1 <= len(options.checkpoints) <= MAX_MODELS:
        raise InputError(f"from 1 to {MAX_MODELS} checkpoints, got {len(options.checkpoints)}")
    device = choose_device(options.device)
    return tuple(load_checkpoint(path).to(device) for path in options.checkpoints)


def describe_models(models: tuple[RNNPB, ...], options: ServerOptions) -> Facts:
    eyes = {} if options.data is None else eye_tracks(options.data)
    names = model_names(options.checkpoints)

    @cache  # models of the same joints share their motions
    def read(data: str, joints: tuple[str, ...], fps: float) -> Dataset:
        dataset = load_dataset(data, joints, options.said, fps)
        for remark in dataset.remarks:
            log.warning("%s", remark)
        return dataset

    return tuple(
        _describe(
            model,
            name,
            None if options.data is None else read(options.data, model.info.joints, model.info.fps),
            eyes,
        )
        for model, name in zip(models, names, strict=True)
    )


def eye_tracks(data: str) -> dict[str, EyeTrack]:
    """The eye colours in the data; motions are as good without."""
    try:
        return load_eyes(data)
    except InputError as error:
        log.warning("no eye colours: %s", error)
        return {}


def model_names(checkpoints: tuple[str, ...]) -> list[str]:
    """Short names: the file's, or its folder's for a published `model.tar`; numbered if equal."""
    paths = [Path(path) for path in checkpoints]
    names = [
        path.parent.name if path.name == "model.tar" and path.parent.name else path.stem
        for path in paths
    ]
    if len(set(names)) < len(names):
        names = [f"{name} ({i})" for i, name in enumerate(names, 1)]
    return names


def _describe(
    model: RNNPB, name: str, dataset: Dataset | None, eyes: dict[str, EyeTrack]
) -> ModelFacts:
    count = model.config.num_motions
    info = model.info if dataset is None else dataset.complete(model)
    mu = model.mu.detach().cpu().numpy().astype(np.float64)
    names = info.motions or tuple(f"motion {i}" for i in range(count))
    return ModelFacts(
        name=name,
        mu=mu,
        sigma=model.sigma.detach().cpu().numpy().astype(np.float64),
        stochastic=model.stochastic,
        beta=model.config.beta,
        joints=info.joints,
        fps=info.fps,
        motions=names,
        lengths=info.lengths or (UNKNOWN_LENGTH,) * count,
        labels=info.labels,
        latent_map=LatentMap.fit(mu),
        data=(None,) * count if dataset is None else dataset.learned_by(model),
        eyes=tuple(map(eyes.get, names)) if eyes else (),
    )


def opening(facts: Facts, model: RNNPB, options: ServerOptions) -> Document:
    """The document that every new page begins with."""
    motion = liveliest(facts[0])
    if options.motion is not None:
        names = facts[0].motions
        motion = (
            names.index(options.motion)
            if options.motion in names
            else model.motion_index(options.motion)
        )
    document = opening_document(facts, options.seed, motion)
    if options.state_code is not None:
        document = decode(facts, options.state_code)
    if options.frame is not None:
        last = motion_steps(facts, document, 0) - 1
        if not 0 <= options.frame <= last:
            raise InputError(f"frame {options.frame} is not within 0 to {last}")
        phase = options.frame / max(last, 1)
        playback = replace(document.playback, playing=False, phase=phase)
        document = replace(document, playback=playback)
    return document


def liveliest(facts: ModelFacts) -> int:
    """The motion to open with: the one of the highest arousal, or the first where none is rated."""
    labels = [facts.labels.get(name) for name in facts.motions]
    ratings = [label.arousal or 0.0 if label is not None else 0.0 for label in labels]
    return ratings.index(max(ratings))


def remarks(robot: Robot) -> list[str]:
    """The first of what is not as its description says."""
    rest = len(robot.warnings) - MOST_REMARKS
    more = [f"and {rest} more remarks on {robot.name}; rnnpb robot lists them"] if rest > 0 else []
    return [*robot.warnings[:MOST_REMARKS], *more]


def unmatched_joints(robot: Robot, facts: Facts) -> list[str]:
    """One line a model that moves joints which the robot lacks."""
    lines = []
    for one in facts:
        missing = match_joints(robot, one.joints).missing
        if len(missing) == len(one.joints):
            lines.append(none_matches(robot, one))
        elif missing:
            lines.append(f"{robot.name} lacks joints that {one.name} moves: {', '.join(missing)}")
    return lines


def serve(options: ServerOptions, guard: Guard) -> viser.ViserServer:
    """The bare viser server on the wanted port, behind its door.

    Raises:
        InputError: the port is taken.
    """
    _claim(options.host, options.port)
    # A browser that goes while its session writes is no news.
    warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
    with contextlib.redirect_stdout(io.StringIO()):  # viser prints a banner of its own
        server = guard.start(host=options.host, port=options.port, verbose=False)
    server.gui.configure_theme(show_share_button=False, show_logo=False, control_width="medium")
    return server


def _claim(host: str, port: int) -> None:
    """viser takes the next free port without a word; the one asked for must be free."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            taken = error.errno in (errno.EADDRINUSE, errno.EACCES)
            advice = "choose another --port (0: any)" if taken else "--host is no address of here"
            raise InputError(
                f"cannot serve on {host}:{port}: {error.strerror}; {advice}"
            ) from error
