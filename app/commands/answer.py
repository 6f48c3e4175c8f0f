"""How every command answers: its exit code, and one plain line on stderr for what went wrong.

0 done, 2 bad input (the line says what, where, and what would be right), 130 interrupted, 141 the
reader of a pipe has gone, 1 a fault of the program itself.
"""

from __future__ import annotations

import importlib.metadata
import os
import sys
from collections.abc import Sequence

from cyclopts import App, Argument, CycloptsError, Parameter, Token
from cyclopts import exceptions as refused
from cyclopts.help import DefaultFormatter, PanelSpec
from rich.box import Box

from ...core.errors import InputError
from ...core.threads import wait_without_spinning

SUCCESS, FAULT, BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 130, 141
NO_BOX = Box("    \n" * 8)


def make_app(name: str, summary: str) -> App:
    """A command line in the way of this program: plain help, no abbreviations, no `--no-...`."""
    return App(
        name=name,
        help=summary,
        version=lambda: f"{name} {importlib.metadata.version('rnnpb-explorer')}",
        help_format="markdown",  # as docstrings are: a line may end anywhere
        help_formatter=DefaultFormatter(panel_spec=PanelSpec(box=NO_BOX, padding=(0, 0, 0, 3))),
        default_parameter=Parameter(
            negative=(),
            allow_repeating=True,  # the last one counts
            show_default=_shown,
        ),
    )


def _shown(default: object) -> str | None:
    """The default of a flag as the help shows it; none for switches, and for what is not given."""
    if default is None or default is False:
        return None
    return ",".join(map(str, default)) if isinstance(default, tuple) else str(default)


def answer(app: App, argv: Sequence[str] | None = None) -> int:
    """Run the command that `argv` asks for and return the exit code; bad input raises nothing."""
    argv = list(sys.argv[1:] if argv is None else argv)
    wait_without_spinning()
    called = app.name[0]
    try:
        if not argv and app.default_command is None:
            raise InputError("the following arguments are required: COMMAND; --help lists them")
        command, bound, _ = app.parse_args(argv, exit_on_error=False, print_error=False)
        called = " ".join((called, *app.parse_commands(argv)[0]))
        command(*bound.args, **bound.kwargs)
        sys.stdout.flush()
    except CycloptsError as error:
        asked = " ".join((called, *(error.command_chain or ())))
        return _fail(called, f"{_complaint(error, argv)} ({asked} --help lists the flags)")
    except InputError as error:
        return _fail(called, str(error))
    except KeyboardInterrupt as interruption:
        return _fail(called, str(interruption) or "interrupted", INTERRUPTED)
    except BrokenPipeError:
        # The reader of a pipe (`| head`) has had enough. Python would complain once more when it
        # flushes stdout at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except SystemExit:  # what rich makes of a broken pipe, while it prints the help
        return BROKEN_PIPE
    except (OSError, MemoryError) as error:
        return _fail(called, f"{type(error).__name__}: {error}")
    except Exception as error:
        # The outermost boundary: a person at a terminal gets one line, a developer can ask for all.
        if os.environ.get("RNNPB_TRACEBACK"):
            raise
        text = f"fault in the program, {type(error).__name__}: {error}"
        return _fail(called, f"{text} (RNNPB_TRACEBACK=1 shows where)", FAULT)
    return SUCCESS


def _fail(called: str, message: str, code: int = BAD_INPUT) -> int:
    # A name out of a file may hold anything; what is printed is one line all the same.
    line = " ".join("".join(c if c.isprintable() else " " for c in message).split())
    print(f"{called}: {line}", file=sys.stderr)
    return code


def _complaint(error: CycloptsError, argv: Sequence[str]) -> str:
    """What is wrong with the flags, in the words that people know from other commands."""
    name = error.argument.name if error.argument else ""
    match error:
        case refused.UnknownCommandError(app=App() as app, unused_tokens=[first, *_]):
            commands = ", ".join(command for command in app if not command.startswith("-"))
            return f"invalid choice: {first!r} (choose from {commands})"
        case refused.ConsumeMultipleError():
            return f"argument {name}: expected at least one argument"
        case refused.MissingArgumentError(keyword=None, app=App() as app):
            return f"the following arguments are required: {_missing(app, name, argv)}"
        case refused.MissingArgumentError():
            return f"argument {name}: expected one argument"
        case refused.UnknownOptionError():
            return f"unrecognized arguments: {error.token.keyword or error.token.value}"
        case refused.UnusedCliTokensError(unused_tokens=[*tokens]):
            return f"unrecognized arguments: {' '.join(tokens)}"
        case refused.CoercionError(msg=str(words)):
            return f"argument {name}: {words}"
        case refused.CoercionError(argument=Argument() as argument, token=Token() as token):
            choices = argument.get_choices(force=True)
            if choices:
                choice = f"{token.value!r} (choose from {', '.join(choices)})"
                return f"argument {name}: invalid choice: {choice}"
        case refused.ValidationError():
            return error.exception_message
    error.verbose = False
    return str(error)


def _missing(app: App, first: str, argv: Sequence[str]) -> str:
    """What a command needs and did not get: `first`, and every flag that is not in `argv`."""
    given = {word.split("=")[0] for word in argv}
    needed = (each for each in app.assemble_argument_collection() if each.required)
    return ", ".join(
        each.name
        for each in needed
        if each.name == first or (each.name.startswith("--") and given.isdisjoint(each.names))
    )
