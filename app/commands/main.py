"""`rnnpb`: the explorer's work without a browser.

Every command is one module in `commands`. Exit codes: 0 done, 2 bad input (one line on stderr says
what, where, and what would be right), 130 interrupted, 1 a fault of the program itself.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
import sys
from collections.abc import Sequence

from ...core.errors import InputError
from ...core.threads import wait_without_spinning
from . import COMMANDS
from .command import Command, Parser

SUCCESS, FAULT, BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 130, 141


def main(argv: Sequence[str] | None = None, commands: Sequence[Command] = COMMANDS) -> int:
    """Run one command and return the exit code; nothing is raised for bad input."""
    argv = sys.argv[1:] if argv is None else argv
    wait_without_spinning()
    called = "rnnpb"
    try:
        arguments = build_parser(commands).parse_args(_join_negative_numbers(argv))
        called = f"rnnpb {arguments.command}"
        arguments.run(arguments)
        sys.stdout.flush()
    except SystemExit as exit_:  # argparse leaves this way after --help and --version
        return int(exit_.code or SUCCESS)
    except InputError as error:
        return _fail(called, str(error), BAD_INPUT)
    except KeyboardInterrupt as interruption:
        return _fail(called, str(interruption) or "interrupted", INTERRUPTED)
    except BrokenPipeError:
        # The reader of a pipe (`| head`) has had enough. Python would complain once more when it
        # flushes stdout at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except (OSError, MemoryError) as error:
        return _fail(called, f"{type(error).__name__}: {error}", BAD_INPUT)
    except Exception as error:
        # The outermost boundary: a person at a terminal gets one line, a developer can ask for all.
        if os.environ.get("RNNPB_TRACEBACK"):
            raise
        text = f"fault in the program, {type(error).__name__}: {error}"
        return _fail(called, f"{text} (RNNPB_TRACEBACK=1 shows where)", FAULT)
    return SUCCESS


def build_parser(commands: Sequence[Command]) -> Parser:
    parser = Parser(
        prog="rnnpb", description="Stochastic RNNPB models without a browser.", allow_abbrev=False
    )
    parser.add_argument("--version", action="version", version=_version())
    choices = parser.add_subparsers(
        dest="command", metavar="COMMAND", required=True, parser_class=Parser
    )
    for command in commands:
        own = choices.add_parser(
            command.name,
            help=command.summary,
            description=command.summary,
            allow_abbrev=False,
        )
        command.add_arguments(own)
        own.set_defaults(run=command.run)
    return parser


def _version() -> str:
    return f"rnnpb {importlib.metadata.version('rnnpb-explorer')}"


def _join_negative_numbers(argv: Sequence[str]) -> list[str]:
    """`--mu -1,2` as `--mu=-1,2`: argparse takes a list that starts with a minus for a flag."""
    joined: list[str] = []
    for argument in argv:
        if joined and re.match(r"-\.?\d", argument) and re.fullmatch(r"--[a-z-]+", joined[-1]):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def _fail(called: str, message: str, code: int) -> int:
    # A name out of a file may hold anything; what is printed is one line all the same.
    line = " ".join("".join(c if c.isprintable() else " " for c in message).split())
    print(f"{called}: {line}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
