"""`rnnpb-explorer`: serve the explorer until Ctrl-C or SIGTERM."""

from __future__ import annotations

import gc
import getpass
import os
import signal
import sys
import threading
from collections.abc import Sequence
from typing import Annotated

from .answer import answer, make_app
from .flags import Data, DeviceName, FileFlags, Robot, Seed, note, read_by, whole
from .progress import working


def main(argv: Sequence[str] | None = None) -> int:
    """Run the server; 0 when it was asked to end, 2 on bad input."""
    app = make_app(
        "rnnpb-explorer", "Explore the latent space of a stochastic RNNPB in the browser."
    )
    app.default(run)
    return answer(app, argv)


def run(
    file: FileFlags | None = None,
    *,
    ckpt: tuple[str, ...] = ("strong.pt",),
    models: str | None = None,
    lessons: str | None = None,
    host: str = "127.0.0.1",
    port: Annotated[int, read_by(whole(0, 65535))] = 8080,
    token: str | None = None,
    no_token: bool = False,
    allow_origin: tuple[str, ...] = (),
    allow_frame: tuple[str, ...] = (),
    robot: Robot = "pepper",
    data: Data | None = None,
    device: DeviceName = "auto",
    seed: Seed = 0,
) -> None:
    """Serve until a signal comes.

    Args:
        ckpt: a path, or a shipped name such as strong; twice: two models side by side
        models: a folder of checkpoints that the page offers beside those that are shipped
        lessons: a folder of lessons (*.toml) that the page offers beside those that are shipped
        host: the address to serve on; by default only this machine reaches it
        port: 0: any free one
        token: no page without it; needed with a --host for others
        no_token: let everybody in who reaches --host
        allow_origin: where a proxy shows the page: https://name[:port]
        allow_frame: a site that may embed the page: https://name[:port]
    """
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    with working("loading the models and the robot"):
        from ..page.door import is_loopback
        from ..page.server import ServerOptions, start

        options = ServerOptions(
            checkpoints=ckpt,
            models=models,
            lessons=lessons,
            host=host,
            port=port,
            token=token,
            no_token=no_token,
            allow_origins=allow_origin,
            allow_frames=allow_frame,
            robot=robot,
            data=data,
            said=(file or FileFlags()).said,
            device=device,
            seed=seed,
        )
        app = start(options)
    # What is loaded by now stays. Python's collector comes the more seldom the more there is:
    # counted with it, what pages leave behind would pile up for hundreds of them.
    gc.collect()
    gc.freeze()
    if no_token and not is_loopback(host):
        note(
            f"rnnpb-explorer: serving on {host}: everybody who reaches this machine can "
            "use the page; there is no password"
        )
    if app.link_for_others is not None:
        note(f"rnnpb-explorer: others open {app.link_for_others}")
    if is_loopback(host) and "SSH_CONNECTION" in os.environ:
        note(f"rnnpb-explorer: on the machine that you sit at: {tunnel(app.url)}")
    print(f"rnnpb-explorer is ready at {app.link}", flush=True)
    ended.wait()
    app.stop()


def tunnel(url: str) -> str:
    """The command that brings a port of this machine to the one at the other end of ssh."""
    port = url.rpartition(":")[2]
    machine = os.environ["SSH_CONNECTION"].split()[2]  # the address that ssh was called with
    return f"ssh -N -L {port}:127.0.0.1:{port} {getpass.getuser()}@{machine}"


if __name__ == "__main__":
    sys.exit(main())
