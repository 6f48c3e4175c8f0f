"""The REBL-Pepper files: fetched from where their authors publish them, or taken from a folder.

They are checked against the SHA-256 of the files that the shipped models were trained on, and kept
in the user's cache. None of them is part of this package.
"""

from __future__ import annotations

import logging
import shutil
from pathlib import Path

import pooch
import requests

from ..core.errors import InputError
from ..core.files import CACHE_VARIABLE, replacing

REPOSITORY = "https://github.com/minamar/rebl-pepper-data"
BASE_URL = (
    "https://raw.githubusercontent.com/minamar/rebl-pepper-data/"
    "fedc89aca4d60e135a78e7bf5acb429f788b1a06/original_animations/"
)
SHA256 = {
    "data_raw.csv": "441d56396fdcc8606d4d5c576e05075c36c87f5d0509647c7d102ae82cca9eec",
    "labels_augmented.csv": "978455c051aa9c564cd7586951b4472b2bebb83392aa9134aac2649ec322ff98",
}
RETRIES = 2
TIMEOUT = 30.0  # seconds without an answer

LICENCE = f"""\
REBL-Pepper: 36 emotional animations of the robot Pepper, from {REPOSITORY}
Licence: CC BY 4.0, https://creativecommons.org/licenses/by/4.0/
Please cite:
  M. Marmpena, A. Lim, T. S. Dahl, "How does the robot feel? Perception of valence and arousal in
    emotional body language", Paladyn 9(1), 2018, https://doi.org/10.1515/pjbr-2018-0012
  M. Marmpena, A. Lim, T. S. Dahl, N. Hemion, "Generating robotic emotional body language with
    variational autoencoders", ACII 2019, https://doi.org/10.1109/ACII.2019.8925459
  M. Marmpena, F. Garcia, A. Lim, "Generating robotic emotional body language of targeted valence
    and arousal with conditional variational autoencoders", HRI 2020,
    https://doi.org/10.1145/3371382.3378360"""


def fetch() -> Path:
    """The folder in the user's cache with the files; what is missing there is downloaded.

    Raises:
        InputError: the download fails, or is not the file that is expected.
    """
    cache = _cache()
    # pooch tells of every download on stderr; here it is the command that speaks.
    pooch.get_logger().setLevel(logging.WARNING)
    for name in SHA256:
        try:
            cache.fetch(name, downloader=pooch.HTTPDownloader(timeout=TIMEOUT))
        except requests.RequestException as error:
            raise InputError(
                f"cannot fetch {cache.get_url(name)} ({type(error).__name__}); with the files at "
                "hand, rnnpb data --path FOLDER takes them from there"
            ) from error
        except OSError as error:
            raise InputError(f"cannot write {cache.abspath / name}: {error.strerror}") from error
        except ValueError as error:
            raise InputError(
                f"{cache.get_url(name)} is not the file that was expected: its SHA-256 is not "
                f"{SHA256[name]}"
            ) from error
    return Path(cache.abspath)


def take(path: Path) -> Path:
    """The folder in the user's cache, after copying the files there from `path`.

    Args:
        path: the folder with the files, a clone of the published repository, or `data_raw.csv`.

    Raises:
        InputError: a file is missing there, or is not the published one.
    """
    folder = path.parent if path.is_file() else path
    if (folder / "original_animations").is_dir():
        folder = folder / "original_animations"
    for name, expected in SHA256.items():
        if not (folder / name).is_file():
            raise InputError(f"there is no {name} in {folder}")
        if pooch.file_hash(str(folder / name)) != expected:
            raise InputError(
                f"{folder / name} is not the published file: its SHA-256 is not {expected}"
            )
    target = Path(_cache().abspath)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {target}: {error.strerror}") from error
    for name in SHA256:
        with replacing(target / name) as beside:
            shutil.copyfile(folder / name, beside)
    return target


def _cache() -> pooch.Pooch:
    return pooch.create(
        path=pooch.os_cache("rnnpb-explorer") / "rebl-pepper",
        base_url=BASE_URL,
        registry={name: f"sha256:{digest}" for name, digest in SHA256.items()},
        env=CACHE_VARIABLE,
        retry_if_failed=RETRIES,
    )
