"""Training motions: REBL-Pepper as published, or files of motions in a folder.

REBL-Pepper: M. Marmpena, F. Garcia, A. Lim, N. Hemion, T. Wennekers, "Data-driven emotional body
language generation for social robotics", CC BY 4.0. Section IV.A of the paper uses it with each
posture mirrored, 72 motions in all.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from ..core.csv_table import read_csv_bytes
from ..core.data import LABEL_FILES, MIRROR_SUFFIX, Dataset, labels_beside
from ..core.errors import InputError
from ..core.motion import MAX_CSV_BYTES, Motion, MotionLabel
from .pepper import PEPPER_JOINTS, mirror
from .reading import SUFFIXES, NoJoints, Reading, Said, joints_in, read_motions

REBL_PEPPER_FPS = 25.0
MAX_DATA_BYTES = 100_000_000
MOST_FILES = 10_000
TABLES = (".csv", ".tsv")  # of these it is a fault where one is no motion


def load_dataset(
    path: str | os.PathLike[str],
    joints: tuple[str, ...] | None = None,
    said: Said | None = None,
    fps: float | None = None,
) -> Dataset:
    """Load REBL-Pepper's `data_raw.csv` (mirrored to 72 motions) or a folder of motion files.

    Args:
        path: the file, the folder that holds `data_raw.csv`, or a folder of motions; a folder in it
            is the class of its motions.
        joints: the joints to read from a folder's files. By default Pepper's where the first file
            has them all, else those that most files name.
        said: what somebody says of a folder's files.
        fps: frames a second that a folder's motions are to have; None: the rate of most of them.

    Raises:
        InputError: nothing there, or a file that is not what it should be.
    """
    path = Path(path)
    try:
        if path.is_dir():
            for folder in (path, path / "original_animations"):  # as in the published repository
                if (folder / "data_raw.csv").is_file():
                    return _load_rebl_pepper(folder / "data_raw.csv")
            return _load_folder(path, joints, said or Said(), fps)
        if path.is_file():
            return _load_rebl_pepper(path)
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
    raise InputError(f"no data at {path}; give REBL-Pepper's data_raw.csv or a folder of CSV files")


def motion_files(path: Path) -> list[Path]:
    """The files of a folder, and of the folders in it, that may be motions, by name.

    Raises:
        InputError: there is none, or too many.
    """
    files = sorted(
        (
            file
            for pattern in ("*", "*/*")
            for file in path.glob(pattern)
            if file.suffix.lower() in SUFFIXES
            and file.is_file()
            and not any(part.startswith(".") for part in file.relative_to(path).parts)
            and file.name not in LABEL_FILES
        ),
        key=lambda file: (file.stem, file),
    )
    if not files:
        raise InputError(f"no CSV file in {path}; expected one a motion")
    if len(files) > MOST_FILES:
        raise InputError(f"{path} has {len(files)} files; at most {MOST_FILES} can be learned from")
    return files


# --- a folder ---
def _load_folder(
    path: Path, joints: tuple[str, ...] | None, said: Said, fps: float | None
) -> Dataset:
    files = motion_files(path)
    contents = {file: read_csv_bytes(file, MAX_CSV_BYTES) for file in files}
    remarks: list[str] = []
    joints = joints or _joints(contents)
    readings: dict[Path, Reading] = {}
    for file, content in contents.items():
        try:
            readings[file] = read_motions(content, file.name, joints, said=said)
        except InputError as error:
            if file.suffix.lower() in TABLES and not isinstance(error, NoJoints):
                raise
            remarks.append(f"{file.relative_to(path)}: left out, {error}")
    if not readings:
        raise InputError(f"no file in {path} has a joint {' or '.join(joints)}")
    fps = fps or said.fps or _common_rate(readings.values())
    for file, reading in readings.items():
        if abs(reading.fps / fps - 1) > 1e-4:
            again = read_motions(contents[file], file.name, joints, said=said, fps=fps)
            readings[file] = again
    motions: list[Motion] = []
    labels: dict[str, MotionLabel] = {}
    beside = labels_beside(path, [file.stem for file in readings])
    for file, reading in readings.items():
        remarks += [f"{file.relative_to(path)}: {remark}" for remark in reading.remarks]
        for motion in reading.motions:
            name = motion.name if len(reading.motions) > 1 else file.stem
            motions.append(replace(motion, name=name))
            label = beside[file.stem]
            if file.parent != path:
                label = replace(label, behavior_class=file.parent.name)
            labels[name] = label
    names = [motion.name for motion in motions]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"{path} has more than one file for {', '.join(twice)}")
    motions.sort(key=lambda motion: motion.name)
    return Dataset(tuple(motions), labels, remarks=_merged(remarks))


def _joints(contents: dict[Path, bytes]) -> tuple[str, ...]:
    """The joints that a folder's motions have.

    Raises:
        InputError: no file names any, or a table names none.
    """
    named: list[tuple[str, ...]] = []
    for file, content in contents.items():
        try:
            named.append(joints_in(content, file.name))
        except InputError:
            if file.suffix.lower() in TABLES or len(contents) == 1:
                raise
    joints = _named_by_most(named)
    return PEPPER_JOINTS if set(PEPPER_JOINTS) <= set(joints) else joints


def _named_by_most(named: list[tuple[str, ...]]) -> tuple[str, ...]:
    """The joints of the first file that shares any with another; where none does, the most."""
    counted = Counter(joint for joints in named for joint in joints)
    shared = (joints for joints in named if any(counted[joint] > 1 for joint in joints))
    return next(shared, max(named, key=len, default=()))


def _common_rate(readings: Iterable[Reading]) -> float:
    """The rate of most motions, where files say one."""
    known = Counter(one.fps for one in readings if one.fps_source != "assumed")
    return known.most_common(1)[0][0] if known else REBL_PEPPER_FPS


def _merged(remarks: list[str]) -> tuple[str, ...]:
    """What is said of several files alike, said once."""
    counted = Counter(remark.partition(": ")[2] for remark in remarks)
    lines, seen = [], set()
    for remark in remarks:
        file, _, what = remark.partition(": ")
        if counted[what] == 1 or not what:
            lines.append(remark)
        elif what not in seen:
            seen.add(what)
            lines.append(f"{file} and {counted[what] - 1} more: {what}")
    return tuple(lines)


# --- REBL-Pepper ---
def _load_rebl_pepper(path: Path) -> Dataset:
    content = read_csv_bytes(path, MAX_DATA_BYTES)
    reading = read_motions(content, path.name, PEPPER_JOINTS, said=Said(REBL_PEPPER_FPS), by="id")
    motions = list(reading.motions)
    names = {motion.name for motion in motions}
    # The published data_augmented.csv has the mirrored motions already.
    motions += [mirror(m) for m in motions if not _mirrored(m.name, names)]
    motions.sort(key=lambda motion: motion.name)
    return Dataset(
        tuple(motions),
        labels_beside(path.parent, [motion.name for motion in motions]),
        attribution="REBL-Pepper, M. Marmpena et al., CC BY 4.0; mirrored",
    )


def _mirrored(name: str, names: Iterable[str]) -> bool:
    return name.endswith(MIRROR_SUFFIX) or name + MIRROR_SUFFIX in names
