"""Writing files so that an existing one is replaced whole or not at all; the user's cache."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import platformdirs

from .errors import InputError

CACHE_VARIABLE = "RNNPB_EXPLORER_CACHE"  # names another folder than the user's cache


def cache_folder(name: str) -> Path:
    """Where in the user's cache things of one kind lie; it need not be there yet."""
    return (
        Path(os.environ.get(CACHE_VARIABLE) or platformdirs.user_cache_dir("rnnpb-explorer")) / name
    )


def check_writable(path: str | os.PathLike[str]) -> Path:
    """The path with links followed, if a file can be put there.

    Asked before a long computation, so that a mistyped folder fails at once and not at the end.

    Raises:
        InputError: it is a folder or a device, its folder is missing, or the system refuses.
    """
    path = Path(os.path.realpath(path))
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder; give the name of a file in it")
    if path.exists() and not path.is_file():
        raise InputError(f"cannot write {path}: it is no ordinary file")
    if not path.parent.is_dir():
        raise InputError(f"cannot write {path}: there is no folder {path.parent}")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"cannot write {path}: no permission to write in {path.parent}")
    return path


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path beside `path` to write to; it takes the name of `path` when all went well.

    Whatever goes wrong, what lay at `path` before still lies there and nothing is left beside it.

    Raises:
        InputError: the file cannot be written, a full disk included.
    """
    path = check_writable(path)
    beside = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield beside
        with beside.open("rb") as file:
            os.fsync(file.fileno())  # or a power cut could leave the name and no content
        os.replace(beside, path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
