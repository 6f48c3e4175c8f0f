"""The one kind of error that a person can mend: input that is not what it should be."""

from __future__ import annotations


class InputError(ValueError):
    """Bad input: a file, a flag, a checkpoint, a message.

    The message is one plain line that says what is wrong, where, and what would be right. Commands
    print it and exit with code 2; the app shows it as a notice and goes on.
    """


class Cancelled(Exception):
    """A long computation was told to stop, and did; it has no result."""
