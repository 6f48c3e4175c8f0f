"""The server: loads the models once, and opens a session for every browser that comes."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import random
import socket
import threading
import warnings
from dataclasses import dataclass
from functools import partial

import viser
from msgspec.structs import replace

from ...core.errors import InputError
from ...robot.description import Robot, load_robot, match_joints
from ...robot.reading import NOTHING_SAID, Said
from ..engine.engine import Engine
from ..state import intents as do
from ..state.document import Document
from ..state.facts import Facts, ModelFacts
from ..state.opening import check_fits, opening_document
from ..state.statecode import unpacked
from ..state.wanted import motion_steps
from .bridge import reload_in
from .door import WILDCARDS, address_for_others, make_door, url_host
from .gate import FileTransferStartUpload
from .guard import Guard, page_scripts
from .lessons import load_lessons
from .library import Library
from .presenting import Presentations
from .robot_nodes import add_robot
from .robots import ROOT
from .session import Session
from .stage import staged
from .studio import set_up_studio
from .uploads import TOO_LARGE
from .words import none_matches

MAX_SESSIONS = 64  # pages open at once; each has threads and a screen of its own
MOST_REMARKS = 8  # on the robot, in the log
STOP_SECONDS = 5.0  # that a session's threads get to end when the server stops
FULL = (
    "**This server shows {} pages already, as many as it takes.** As soon as one is closed there "
    "is room for another: this page tries again every {:.0f} seconds."
)
RETRY_SECONDS = 10.0  # of a page that found no room; at random up to half as long again
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServerOptions:
    """What the command line decides."""

    checkpoints: tuple[str, ...] = ("strong.pt",)
    models: str | None = None  # a folder of more of them, to open on the page
    lessons: str | None = None  # a folder of lessons
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
        self.lessons = load_lessons(options.lessons)
        self.library = open_library(options)
        self.robot = load_robot(options.robot)
        self.facts = self.library.started
        for warning in (*unmatched_joints(self.robot, self.facts), *remarks(self.robot)):
            log.warning("%s", warning)
        self.opening = opening(self.library, options)
        self._presentations = Presentations()
        self._lock = threading.Lock()
        self.sessions: dict[int, Session] = {}
        guard = Guard(door)
        guard.too_large = self._refuse_upload
        self._server = serve(options, guard)
        set_up_studio(self._server.scene)
        self._staged = staged(self.robot)
        add_robot(self._server.scene, self._staged, ROOT)
        self._engine = Engine(self.library.models, self.library.data, self.robot)
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
                    self.library,
                    self.lessons,
                    self._presentations,
                    self._engine,
                    self._staged,
                    self.opening,
                    partial(self._disconnected, client),
                )
        if full:
            log.warning("a browser was refused: there are %d pages", MAX_SESSIONS)
            client.gui.add_markdown(FULL.format(MAX_SESSIONS, RETRY_SECONDS))
            reload_in(client, RETRY_SECONDS * random.uniform(1.0, 1.5))
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


def open_library(options: ServerOptions) -> Library:
    """The models of the command line, and what else pages may open."""
    return Library(
        options.checkpoints,
        folder=options.models,
        data=options.data,
        said=options.said,
        device=options.device,
    )


def opening(library: Library, options: ServerOptions) -> Document:
    """The document that every new page begins with."""
    facts = library.started
    motion = liveliest(facts[0])
    if options.motion is not None:
        names = facts[0].motions
        motion = (
            names.index(options.motion)
            if options.motion in names
            else library.models[facts[0].name].motion_index(options.motion)
        )
    document = opening_document(facts, options.seed, motion)
    if options.state_code is not None:
        document = unpacked(options.state_code)
        facts = library.facts(choice.name for choice in document.models)
        check_fits(facts, document)
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
