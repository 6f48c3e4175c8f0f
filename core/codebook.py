"""A codebook of a model: many PBs and, sparsely in time, the motions that they make.

Local steps from the learned mu miss better explanations of motions that the model never learnt. To
compare an observation with thousands of motions that are at hand is one subtraction: the best of
them are where recognition starts from (`starts`), and over all of them Bayes' rule is exact
(belief.py). The PBs are the learned mu, points between pairs of them, and a wide Gaussian, in an
order of which every beginning is a codebook of its own: one uses it while it grows.
"""

from __future__ import annotations

import hashlib
import logging
import math
import os
import threading
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from .errors import InputError
from .files import cache_folder, replacing
from .latent_map import spread
from .model import RNNPB

SIZE = 16_384
FRAMES = 420  # of a motion; what is observed beyond them is left out of the comparison
STRIDE = 12  # frames from one that is kept to the next
BATCH = 64  # motions that are generated together
SMALLEST = 1_024  # entries of a codebook of a wide network, whose motions take longer
HIDDEN = 256  # units of the network that SIZE is for
BETWEEN = 0.1  # sd of mu, round a point on the line between two learned ones
WIDE = 1.3  # sd of mu, of the Gaussian round all of them
APART = 0.25  # sd of mu that two starts lie apart at least
CANDIDATES = 200  # of the best entries, among which starts are looked for
KEPT = 8  # codebooks in the user's cache

FORMAT = f"rnnpb-explorer codebook 1: {FRAMES} {STRIDE} {BETWEEN} {WIDE}"
log = logging.getLogger(__name__)


class Codebook:
    """N PBs and their motions at every STRIDE-th frame, in half precision; it grows by `grow`.

    Several threads may grow and use it at the same time: each takes a batch of its own, and what is
    used are the first `entries`.

    Attributes:
        pbs: (N, D).
        motions: (N, K, J) float16, filled as far as it has grown.
    """

    stride = STRIDE

    def __init__(self, model: RNNPB, size: int | None = None, seed: int = 0) -> None:
        """
        Args:
            size: N; by default SIZE, fewer for a network that is wider than usual.
        """
        self.model = model
        self.pbs = codebook_pbs(model, size or size_for(model), seed)
        kept = -(-FRAMES // STRIDE)
        self.motions = torch.zeros(
            (len(self.pbs), kept, model.config.num_joints), dtype=torch.float16
        )
        self.scale = spread(model.mu.detach().cpu())
        self._done = np.zeros(-(-len(self.pbs) // BATCH), dtype=bool)
        self._todo = list(range(len(self._done)))[::-1]  # the next one at the end
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self.pbs)

    @property
    def entries(self) -> int:
        """How many of the PBs, from the first on, have their motion."""
        batches = len(self._done) if self._done.all() else int(self._done.argmin())
        return min(batches * BATCH, len(self))

    @property
    def complete(self) -> bool:
        return self.entries == len(self)

    def grow(self, at_once: int = FRAMES) -> Iterator[None]:
        """Make the next batch of motions, in pieces of `at_once` frames; nothing where all are."""
        with self._lock:
            if not self._todo:
                return
            batch = self._todo.pop()
        try:
            yield from self._make(batch, at_once)
        finally:
            if not self._done[batch]:  # given up half-way: it is for somebody else to make
                with self._lock:
                    self._todo.append(batch)

    def _make(self, batch: int, at_once: int) -> Iterator[None]:
        rows = slice(batch * BATCH, (batch + 1) * BATCH)
        first = 0
        with torch.inference_mode():
            pieces = self.model.generate_in_parts(self.pbs[rows].to(self.model.mu), FRAMES, at_once)
        while True:
            with torch.inference_mode():
                part = next(pieces, None)
            if part is None:
                break
            kept = range(-first % STRIDE, part.shape[1], STRIDE)  # of this part's frames
            place = -(-first // STRIDE)
            self.motions[rows, place : place + len(kept)] = part[:, kept].cpu().half()
            first += part.shape[1]
            yield
        self._done[batch] = True

    def frame_errors(
        self, observation: ArrayLike, joints: ArrayLike | None = None
    ) -> NDArray[np.float32]:
        """(n, k) of the n entries the squared errors at each kept frame, averaged over joints.

        Args:
            observation: (T, J), from the first frame on; k of its frames are kept ones.
            joints: indices of those that are observed; None: all.
        """
        kept = np.asarray(observation, np.float32)[:FRAMES:STRIDE]
        which = slice(None) if joints is None else np.asarray(joints, np.intp)
        target = torch.tensor(kept[:, which])
        motions = self.motions[: self.entries, : len(kept), which]
        errors = [
            (part.float() - target).square().mean(dim=2).numpy() for part in motions.split(1024)
        ]
        return np.concatenate(errors) if errors else np.zeros((0, len(kept)), np.float32)

    def starts(self, observation: ArrayLike, count: int, joints: ArrayLike | None = None) -> Tensor:
        """(count, D) or fewer: the PBs that explain best and lie apart, the best first."""
        losses = self.frame_errors(observation, joints).mean(axis=1)
        candidates = np.argsort(losses, kind="stable")[:CANDIDATES]
        return self.pbs[self._apart(candidates, count)]

    def _apart(self, ranked: NDArray[np.intp], count: int) -> NDArray[np.intp]:
        """At most `count` of ranked entries, each APART from all that come before."""
        chosen: list[int] = []
        for index in ranked:
            gaps = torch.linalg.vector_norm(self.pbs[chosen] - self.pbs[int(index)], dim=1)
            if not chosen or float(gaps.min()) > APART * self.scale:
                chosen.append(int(index))
            if len(chosen) == count:
                break
        return np.array(chosen, dtype=np.intp)

    # --- the user's cache ---
    def save(self) -> None:
        """Keep a complete one for the next time; a cache that cannot be written is no fault."""
        try:
            folder = cache_folder("codebooks")
            folder.mkdir(parents=True, exist_ok=True)
            with replacing(folder / self._name) as beside, beside.open("wb") as file:
                np.save(file, self.motions.numpy(), allow_pickle=False)
            others = sorted(folder.glob("*.npy"), key=lambda path: path.stat().st_mtime)
            for path in others[:-KEPT]:
                path.unlink()
        except (OSError, InputError) as error:
            log.warning("the codebook was not kept: %s", error)

    def restore(self) -> bool:
        """Take all motions from the user's cache; whether they lay there."""
        path = cache_folder("codebooks") / self._name
        try:
            motions = np.load(path, allow_pickle=False)
        except (OSError, ValueError, EOFError):
            return False
        if motions.shape != tuple(self.motions.shape) or motions.dtype != np.float16:
            return False
        if not np.isfinite(motions).all():
            return False
        with suppress(OSError):
            os.utime(path)  # of those that were used last KEPT stay
        with self._lock:
            self.motions.copy_(torch.from_numpy(motions))
            self._todo.clear()
            self._done[:] = True
        return True

    @property
    def _name(self) -> str:
        """The file that holds it: named after all that it follows from."""
        digest = hashlib.sha256(FORMAT.encode())
        for tensor in (*self.model.network_parameters(), self.pbs):
            digest.update(tensor.detach().cpu().contiguous().numpy().tobytes())
        return f"{digest.hexdigest()[:32]}.npy"


def size_for(model: RNNPB) -> int:
    """How many entries are worth their time: a frame of a wider network takes longer."""
    share = min(1.0, (HIDDEN / model.config.hidden_size) ** 2)
    return max(SMALLEST, math.ceil(SIZE * share / BATCH) * BATCH)


def codebook_pbs(model: RNNPB, size: int, seed: int = 0) -> Tensor:
    """(size, D): the learned mu, then in turns a point between two of them and a wide one."""
    random = np.random.default_rng(seed)
    mu = model.mu.detach().cpu().double().numpy()  # (N, D)
    sd = mu.std(axis=0, ddof=1) if len(mu) > 1 else np.ones(mu.shape[1])
    count = max(size - len(mu), 0)
    first, second = mu[random.integers(len(mu), size=(2, count))]
    share = random.random((count, 1))
    noise = random.standard_normal((count, mu.shape[1])) * sd
    between = share * first + (1 - share) * second + BETWEEN * noise
    wide = mu.mean(axis=0) + WIDE * noise
    drawn = np.where(np.arange(count)[:, None] % 2 == 0, between, wide)
    return torch.as_tensor(np.concatenate([mu, drawn])[:size], dtype=torch.float32)


def complete_codebook(model: RNNPB, size: int | None = None) -> Codebook:
    """A whole one, from the user's cache or made now and kept there."""
    codebook = Codebook(model, size)
    if not codebook.restore():
        while not codebook.complete:
            for _ in codebook.grow():
                pass
        codebook.save()
    return codebook
