"""How every command answers: its exit code, and one plain line on stderr for what went wrong.

0 done, 2 bad input (the line says what, where, and what would be right), 130 interrupted, 141 the
reader of a pipe has gone, 1 a fault of the program itself.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

from cyclopts import App, Argument, CycloptsError, Parameter, Token
from cyclopts import exceptions as refused

from ...core.errors import InputError
from ...core.threads import wait_without_spinning

SUCCESS, FAULT, BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 0, 1, 2, 130, 141


def make_app(name: str, summary: str, **settings: Any) -> App:
    """A command line in the way of this program: plain help, no abbreviations, no `--no-...`."""
    return App(
        name=name,
        help=summary,
        help_format="plaintext",
        help_formatter=plain_panel,
        default_parameter=Parameter(negative=(), allow_repeating=True),
        **settings,
    )


def plain_panel(console: Any, options: Any, panel: Any) -> None:
    """A list of commands or flags without a box around it."""
    from cyclopts.help import DescriptionRenderer, NameRenderer
    from rich.padding import Padding
    from rich.table import Table

    table = Table.grid(padding=(0, 2), expand=True)
    table.add_column(max_width=24)
    table.add_column(ratio=1)
    for entry in panel.entries:
        table.add_row(NameRenderer(24)(entry), DescriptionRenderer()(entry))
    console.print(f"{panel.title}:", Padding(table, (0, 0, 1, 4)), sep="\n", highlight=False)


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
        return _fail(called, f"{_complaint(error, argv)} ({_help(called, error)} lists the flags)")
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


def _help(called: str, error: CycloptsError) -> str:
    return " ".join((called, *(error.command_chain or ()), "--help"))


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
    """The flags that a command needs and that are not there, `first` among them."""
    given = {word.split("=")[0] for word in argv}
    return ", ".join(
        argument.name
        for argument in app.assemble_argument_collection()
        if argument.required and (argument.name == first or given.isdisjoint(argument.names))
    )
