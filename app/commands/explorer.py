"""`rnnpb-explorer`: serve the explorer until Ctrl-C or SIGTERM."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from collections.abc import Sequence

from ...core.errors import InputError
from ...core.threads import wait_without_spinning
from .command import Parser, add_seed, whole


def main(argv: Sequence[str] | None = None) -> int:
    """Run the server; 0 when it was asked to end, 2 on bad input."""
    try:
        arguments = _parser().parse_args(argv)
    except InputError as error:
        return _refuse(error)
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    wait_without_spinning()
    # Imported late, so that --help and a wrong flag answer at once.
    from ..page.door import is_loopback
    from ..page.server import ServerOptions, start

    options = ServerOptions(
        checkpoints=tuple(arguments.ckpt or ("strong.pt",)),
        host=arguments.host,
        port=arguments.port,
        token=arguments.token,
        no_token=arguments.no_token,
        allow_origins=tuple(arguments.allow_origin),
        allow_frames=tuple(arguments.allow_frame),
        robot=arguments.robot,
        data=arguments.data,
        device=arguments.device,
        seed=arguments.seed,
    )
    try:
        app = start(options)
    except InputError as error:
        return _refuse(error)
    if options.no_token and not is_loopback(options.host):
        print(
            f"rnnpb-explorer: serving on {options.host}: everybody who reaches this machine can "
            "use the page; there is no password",
            file=sys.stderr,
        )
    print(f"rnnpb-explorer is ready at {app.link}", flush=True)
    ended.wait()
    app.stop()
    return 0


def _refuse(error: InputError) -> int:
    line = " ".join("".join(c if c.isprintable() else " " for c in str(error)).split())
    print(f"rnnpb-explorer: {line}", file=sys.stderr)
    return 2


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="rnnpb-explorer",
        description="Explore the latent space of a stochastic RNNPB in the browser.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "--ckpt",
        action="append",
        metavar="CKPT",
        help="a path, or a shipped name such as strong; twice: two models side by side",
    )
    parser.add_argument("--host", default="127.0.0.1", help="default: only this machine")
    parser.add_argument(
        "--port", type=whole(0, 65535), default=8080, help="0: any free one (default: 8080)"
    )
    _add_door(parser)
    parser.add_argument(
        "--robot", default="pepper", metavar="ROBOT", help="pepper, PATH.urdf or NAME_description"
    )
    parser.add_argument("--data", metavar="CSV", help="the training motions, as targets")
    parser.add_argument("--device", default="auto", choices=("auto", "cpu", "cuda"))
    add_seed(parser)
    return parser


def _add_door(parser: argparse.ArgumentParser) -> None:
    """Who may use the page; `door` says what these take."""
    parser.add_argument(
        "--token", metavar="TOKEN", help="no page without it; needed with a --host for others"
    )
    parser.add_argument(
        "--no-token", action="store_true", help="let everybody in who reaches --host"
    )
    parser.add_argument(
        "--allow-origin",
        action="append",
        default=[],
        metavar="ORIGIN",
        help="where a proxy shows the page: https://name[:port]",
    )
    parser.add_argument(
        "--allow-frame",
        action="append",
        default=[],
        metavar="ORIGIN",
        help="a site that may embed the page: https://name[:port]",
    )


if __name__ == "__main__":
    sys.exit(main())
