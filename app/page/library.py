"""The models of a server: those that it was started with, and those that a page may open.

A page names what it shows. Whoever asks for a model first has it loaded; all pages share it.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from ...core.checkpoint import load_checkpoint, resolve_checkpoint, shipped_checkpoints
from ...core.data import Dataset
from ...core.device import choose_device
from ...core.errors import InputError
from ...core.latent_map import LatentMap
from ...core.model import RNNPB, UNKNOWN_LENGTH
from ...core.motion import Motion
from ...robot.data import load_dataset
from ...robot.eyes import load_eyes
from ...robot.reading import Said
from ..state.document import MAX_MODELS, EyeTrack
from ..state.facts import Facts, ModelFacts

MOST_OFFERED = 100  # files of a folder
log = logging.getLogger(__name__)


class Library:
    """
    Args:
        checkpoints: paths or shipped names, loaded at once.
        folder: whose checkpoints pages may open, too. They are looked up among the files that are
            there: no name that comes from a page is ever made a path.
        data: motions that the models are compared with; said: of its files.

    Raises:
        InputError: a checkpoint or data that cannot be used.
    """

    def __init__(
        self,
        checkpoints: tuple[str, ...],
        *,
        folder: str | None = None,
        data: str | None = None,
        said: Said,
        device: str = "auto",
    ) -> None:
        if not 1 <= len(checkpoints) <= MAX_MODELS:
            raise InputError(f"from 1 to {MAX_MODELS} checkpoints, got {len(checkpoints)}")
        if folder is not None and not Path(folder).is_dir():
            raise InputError(f"no folder {folder}")
        self._folder = None if folder is None else Path(folder).resolve()
        self._device = choose_device(device)
        self._eyes = {} if data is None else eye_tracks(data)
        self._lock = threading.Lock()
        self._facts: dict[str, ModelFacts] = {}
        self.models: dict[str, RNNPB] = {}
        self.data: dict[str, tuple[Motion | None, ...]] = {}  # of each model's motions

        @cache  # models of the same joints share their motions
        def recordings(joints: tuple[str, ...], fps: float) -> Dataset | None:
            if data is None:
                return None
            dataset = load_dataset(data, joints, said, fps)
            for remark in dataset.remarks:
                log.warning("%s", remark)
            return dataset

        self._recordings = recordings
        paths = [resolve_checkpoint(one) for one in checkpoints]
        names = model_names(checkpoints)
        self._paths = dict(zip(names, paths, strict=True))
        for path in shipped_checkpoints().values():
            self._offer(path.stem, path)
        self.started: Facts = self.facts(names)

    def offers(self) -> tuple[str, ...]:
        """The names of all models that can be opened; looks into the folder anew."""
        with self._lock:
            for path in [] if self._folder is None else _checkpoints_in(self._folder):
                self._offer(path.parent.name if path.name == "model.tar" else path.stem, path)
            return tuple(self._paths)

    def _offer(self, name: str, path: Path) -> None:
        """By its name, numbered where that is another one's."""
        if any(path.resolve() == known.resolve() for known in self._paths.values()):
            return
        names = (name, *(f"{name} ({number})" for number in range(2, MOST_OFFERED + 2)))
        self._paths[next(one for one in names if one not in self._paths)] = path

    def facts(self, names: Iterable[str]) -> Facts:
        """What is known of these models.

        Raises:
            InputError: there is none of such a name, or its file cannot be used.
        """
        return tuple(self._facts.get(name) or self._load(name) for name in names)

    def _load(self, name: str) -> ModelFacts:
        self.offers()
        with self._lock:
            if name in self._facts:
                return self._facts[name]
            if name not in self._paths:
                known = ", ".join(self._paths)
                raise InputError(f"no model {name[:40]!r} here; there are: {known}")
            model = load_checkpoint(self._paths[name]).to(self._device)
            recordings = self._recordings(model.info.joints, model.info.fps)
            facts = describe(model, name, recordings, self._eyes)
            self.models[name], self.data[name] = model, facts.data
            self._facts[name] = facts
            return facts


def _checkpoints_in(folder: Path) -> list[Path]:
    """Files of a folder, and published `model.tar` in folders of their own; none from elsewhere."""
    found = [*folder.glob("*.pt"), *folder.glob("*.tar"), *folder.glob("*/model.tar")]
    inside = [one for one in found if one.is_file() and one.resolve().is_relative_to(folder)]
    return sorted(inside)[:MOST_OFFERED]


def eye_tracks(data: str) -> dict[str, EyeTrack]:
    """The eye colours in the data; motions are as good without."""
    try:
        return load_eyes(data)
    except InputError as error:
        log.warning("no eye colours: %s", error)
        return {}


def model_names(checkpoints: tuple[str, ...]) -> list[str]:
    """Short names: the file's, or its folder's for a published `model.tar`; numbered if equal."""
    paths = [Path(path) for path in checkpoints]
    names = [
        path.parent.name if path.name == "model.tar" and path.parent.name else path.stem
        for path in paths
    ]
    if len(set(names)) < len(names):
        names = [f"{name} ({i})" for i, name in enumerate(names, 1)]
    return names


def describe(
    model: RNNPB, name: str, dataset: Dataset | None, eyes: dict[str, EyeTrack]
) -> ModelFacts:
    count = model.config.num_motions
    info = model.info if dataset is None else dataset.complete(model)
    mu = model.mu.detach().cpu().numpy().astype(np.float64)
    names = info.motions or tuple(f"motion {i}" for i in range(count))
    return ModelFacts(
        name=name,
        mu=mu,
        sigma=model.sigma.detach().cpu().numpy().astype(np.float64),
        stochastic=model.stochastic,
        beta=model.config.beta,
        joints=info.joints,
        fps=info.fps,
        motions=names,
        lengths=info.lengths or (UNKNOWN_LENGTH,) * count,
        labels=info.labels,
        latent_map=LatentMap.fit(mu),
        data=(None,) * count if dataset is None else dataset.learned_by(model),
        eyes=tuple(map(eyes.get, names)) if eyes else (),
    )
