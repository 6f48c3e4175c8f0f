"""Training: network weights and PBs together, by closed-loop generation (section III.B).

The recipe differs from the published one (50,000 epochs of Adam at 0.001 for everything) where
that is slow: motions run in buckets of similar length, so that little work goes into padding; the
recurrent weights learn by Muon; each PB learns from its own motion only and gets a higher rate; all
rates fall along a cosine.

Each core runs buckets of its own, one thread each. The products of a bucket's single step are too
small to be shared: in two threads they took 1.4 times less time, two buckets side by side take half
of it. As every sum is made in one thread and in the same order, the number of cores changes no bit.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, ClassVar, TypeVar

import torch
from torch import Tensor, nn

from .data import Dataset
from .errors import InputError
from .model import RNNPB, ModelConfig, ModelInfo, kl_divergence
from .muon import Muon

GATES = 4  # of an LSTM, stacked in its weight matrices
# Raised when a recipe begins to teach something else, or its state changes: what was half done
# before cannot go on. What a machine's kernels round differently is no other algorithm: such a run
# goes on, and `processors` in the training record names every kind that it ran on.
ALGORITHM = 4
MOMENTUM = 0.9  # Adam's
MAX_SEQUENCES = 64  # that a core holds the activations of, some 16 kB a frame

T = TypeVar("T")


@dataclass(frozen=True)
class TrainingConfig:
    """A recipe; the model card says which one a shipped checkpoint was trained with."""

    epochs: int = 2500
    samples: int = 1  # PBs sampled a motion and epoch; the second of a pair mirrors the first at mu
    seed: int = 0
    recurrent_rate: float = 0.05  # Muon's, of the recurrent weights: spectral norm of one step
    learning_rate: float = 0.01  # Adam's, of the other weights
    pb_rate_factor: float = 2.0  # mu learns this much faster,
    deterministic_pb_rate_factor: float = (
        0.5  # and without noise slower: the mu stay close together
    )
    sigma_rate_factor: float = 2.0  # log sigma^2
    momentum: float = 0.95  # Muon's
    beta2: float = 0.98  # Adam's, in the first half of a run,
    late_beta2: float = 0.98  # and in the second
    max_gradient_norm: float = 1.0  # of the network's weights
    warm_up_epochs: int = 50
    max_bucket_padding: float = 0.05  # frames of padding a bucket may hold, as a share

    def __post_init__(self) -> None:
        if self.epochs < 1:
            raise InputError(f"epochs must be at least 1, got {self.epochs}")
        if self.samples < 1:
            raise InputError(f"samples must be at least 1, got {self.samples}")


@dataclass(frozen=True)
class TrainingProgress:
    """One finished epoch."""

    epoch: int  # 1 .. epochs
    epochs: int
    loss: float  # eq. 3, as the published code sums it
    error: float  # squared error averaged over frames and joints, at the sampled PBs
    kl: float  # summed over sequences and dimensions
    seconds: float  # since this run, or its resumption, began
    seconds_left: float  # at the speed so far


@dataclass(frozen=True)
class _Bucket:
    rows: Tensor  # (B,) indices of motions
    target: Tensor  # (B, T, J), zero-padded
    mask: Tensor  # (B, T, 1), 1 where a frame is real


class Trainer:
    """One training run, an epoch at a time.

    Attributes:
        precision: of the sums and products.
        muon_dtype: of the products in Muon.

    >>> trainer = Trainer(dataset, ModelConfig(), TrainingConfig())  # doctest: +SKIP
    >>> for progress in trainer.run():  # doctest: +SKIP
    ...     print(progress.error)
    """

    precision: ClassVar[str] = "float32"
    muon_dtype: ClassVar[torch.dtype] = torch.float32

    def __init__(
        self,
        dataset: Dataset,
        config: ModelConfig,
        training: TrainingConfig,
        device: torch.device | str = "cpu",
    ) -> None:
        self.training = training
        self.epoch = 0
        self._random = torch.Generator().manual_seed(training.seed)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(training.seed)  # nn.init has no generator of its own here
            self.model = RNNPB(
                replace(config, num_joints=len(dataset.joints), num_motions=len(dataset.motions)),
                ModelInfo(
                    joints=dataset.joints,
                    fps=dataset.fps,
                    motions=tuple(motion.name for motion in dataset.motions),
                    lengths=tuple(len(motion) for motion in dataset.motions),
                    labels=dataset.labels,
                    attribution=dataset.attribution,
                ),
            ).to(device)
        self.model.info.training["processors"] = _processor(self.model)
        # Only a processor's cores share the work.
        cores = torch.get_num_threads() if self.model.mu.device.type == "cpu" else 1
        self._pool = ThreadPoolExecutor(cores, initializer=torch.set_num_threads, initargs=(1,))
        self._cores = cores
        self._buckets = _make_buckets(dataset, training.max_bucket_padding, device)
        self._frames = sum(len(motion) for motion in dataset.motions)
        model = self.model
        others = [p for p in model.network_parameters() if p is not model.weight_hidden]
        rate = training.learning_rate
        factor = training.pb_rate_factor
        if not model.stochastic:
            factor = training.deterministic_pb_rate_factor
        groups: list[dict[str, Any]] = [
            {"params": [model.mu], "lr": rate * factor},
            {"params": others},
        ]
        if model.stochastic:
            groups.append({"params": [model.log_var], "lr": rate * training.sigma_rate_factor})
        muon = Muon(
            [model.weight_hidden],
            training.recurrent_rate,
            training.momentum,
            matrices=GATES,
            dtype=self.muon_dtype,
            each=self._each,
        )
        self._optimizers: dict[str, torch.optim.Optimizer] = {
            "adam": torch.optim.Adam(groups, rate),
            "muon": muon,
        }
        self._schedules = {
            name: torch.optim.lr_scheduler.LambdaLR(optimizer, self._rate)
            for name, optimizer in self._optimizers.items()
        }

    def _rate(self, epoch: int) -> float:
        """The share of the full rate: a short warm-up, then a cosine down to zero."""
        warm_up = min(1.0, (epoch + 1) / self.training.warm_up_epochs)
        return warm_up * 0.5 * (1 + math.cos(math.pi * epoch / self.training.epochs))

    def run(self) -> Iterator[TrainingProgress]:
        """Train to the last epoch; stop iterating to interrupt."""
        started, first = time.monotonic(), self.epoch
        while self.epoch < self.training.epochs:
            with _one_thread():
                error, kl = self._train_epoch()
            self.epoch += 1
            beta = self.model.config.beta or 0.0
            seconds = time.monotonic() - started
            epochs_left = self.training.epochs - self.epoch
            yield TrainingProgress(
                epoch=self.epoch,
                epochs=self.training.epochs,
                loss=error * self.model.config.num_joints + beta * kl,
                error=error,
                kl=kl,
                seconds=seconds,
                seconds_left=seconds / (self.epoch - first) * epochs_left,
            )

    def _train_epoch(self) -> tuple[float, float]:
        model = self.model
        model.zero_grad()
        pb = model.mu[None]  # (S, N, D)
        kl = torch.zeros(())
        if model.stochastic:
            pb = model.mu + torch.exp(0.5 * model.log_var) * self._draw()  # eq. 1
            kl = kl_divergence(model.mu, model.log_var)
            (kl * (model.config.beta or 0.0)).backward()
        # The PBs are cut off from the graph so that their sampling is run backward only once.
        leaf = pb.detach().requires_grad_()
        squared_error = self._backward_error(leaf)
        pb.backward(leaf.grad)
        # A PB's gradient is its own motion's. If it were clipped, too, the rare large ones of far
        # samples would count for too little against the KL term, and sigma would grow.
        limit = self.training.max_gradient_norm
        late = self.epoch >= self.training.epochs // 2
        beta2 = self.training.late_beta2 if late else self.training.beta2
        for group in self._optimizers["adam"].param_groups:
            group["betas"] = (MOMENTUM, beta2)
        norm = nn.utils.clip_grad_norm_(model.network_parameters(), limit)
        for name, optimizer in self._optimizers.items():
            # A closed loop can amplify a sample's gradient beyond any number; that epoch is lost,
            # the run is not.
            if norm.isfinite():
                optimizer.step()
            self._schedules[name].step()
        return squared_error / model.config.num_joints, kl.item()

    def _draw(self) -> Tensor:
        """Standard normal noise (S, N, D) in antithetic pairs: what is odd in it cancels out."""
        samples, mu = self.training.samples, self.model.mu
        noise = torch.randn(((samples + 1) // 2, *mu.shape), generator=self._random)
        return torch.cat([noise, -noise])[:samples].to(mu.device)

    def _backward_error(self, pb: Tensor) -> float:
        """Squared error summed over joints, mean over frames and samples; its gradients are added.

        Args:
            pb: (S, N, D), a leaf.
        """
        leaves = (*self.model.network_parameters(), pb)
        squared_error = 0.0
        # Some samples of a bucket's motions at a time bound the memory.
        pieces = [
            (bucket, samples)
            for bucket in self._buckets
            for samples in pb.split(max(1, MAX_SEQUENCES // len(bucket.rows)))
        ]
        for error, gradients in self._each(partial(self._piece, leaves), pieces):
            squared_error += error
            for leaf, gradient in zip(leaves, gradients, strict=True):
                leaf.grad = gradient if leaf.grad is None else leaf.grad.add_(gradient)
        return squared_error

    def _piece(
        self, leaves: Sequence[Tensor], piece: tuple[_Bucket, Tensor]
    ) -> tuple[float, Sequence[Tensor]]:
        """What a bucket's motions at some samples (s, N, D) add to the error, and its gradients."""
        bucket, samples = piece
        frames = bucket.target.shape[1]
        generated = self.model.generate(samples[:, bucket.rows].flatten(0, 1), frames)
        error = generated.unflatten(0, (len(samples), -1)) - bucket.target  # (s, B, T, J)
        loss = (error * bucket.mask).square().sum() / (self._frames * len(leaves[-1]))
        return loss.item(), torch.autograd.grad(loss, leaves)

    def _each(self, function: Callable[[Any], T], items: Iterable[Any]) -> Iterable[T]:
        """`map`, with the items spread over the cores; the results in the items' order."""
        return self._pool.map(function, items) if self._cores > 1 else map(function, items)

    def state(self) -> dict[str, Any]:
        """What `restore` needs to go on bit for bit, besides the model."""
        return {
            "training": asdict(self.training),
            "algorithm": ALGORITHM,
            "epoch": self.epoch,
            "optimizers": {name: o.state_dict() for name, o in self._optimizers.items()},
            "schedules": {name: s.state_dict() for name, s in self._schedules.items()},
            "random": self._random.get_state(),
        }

    def restore(self, model: RNNPB, state: dict[str, Any]) -> None:
        """Go on from a checkpoint's model and its `state()`.

        Raises:
            InputError: the checkpoint belongs to another model, other data or another recipe.
        """
        if state.get("training") != asdict(self.training):
            raise InputError("the checkpoint was trained with another recipe, seed or epoch count")
        if state.get("algorithm") != ALGORITHM:
            raise InputError("the checkpoint was begun by a version that learns differently")
        if model.config != self.model.config or model.info.motions != self.model.info.motions:
            raise InputError("the checkpoint belongs to another model or other data")
        self.model.load_state_dict(model.state_dict())
        for name, optimizer in self._optimizers.items():
            optimizer.load_state_dict(state["optimizers"][name])
            self._schedules[name].load_state_dict(state["schedules"][name])
        self._random.set_state(state["random"])
        kinds = str(model.info.training["processors"]).split(", ")
        here = _processor(self.model)
        self.model.info.training["processors"] = ", ".join(dict.fromkeys([*kinds, here]))
        self.epoch = int(state["epoch"])


@contextmanager
def _one_thread() -> Iterator[None]:
    """Of a product; the buckets share the cores (torch keeps the number for MKL process-wide)."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def _processor(model: RNNPB) -> str:
    """What decides how kernels round: the processor's instructions, as torch names them."""
    device = model.mu.device.type
    return torch.backends.cpu.get_cpu_capability() if device == "cpu" else device


def _make_buckets(
    dataset: Dataset, max_padding: float, device: torch.device | str
) -> list[_Bucket]:
    """Motions grouped by length so that at most a share of a bucket's frames is padding."""
    lengths = [len(motion) for motion in dataset.motions]
    groups: list[list[int]] = [[]]
    for index in sorted(range(len(lengths)), key=lambda i: lengths[i]):
        group = [*groups[-1], index]
        padded = len(group) * lengths[index]
        if padded - sum(lengths[i] for i in group) > max_padding * padded:
            groups.append([index])
        else:
            groups[-1] = group
    return [_make_bucket(dataset, group, device) for group in groups]


def _make_bucket(dataset: Dataset, rows: Sequence[int], device: torch.device | str) -> _Bucket:
    motions = [torch.from_numpy(dataset.motions[row].positions) for row in rows]
    target = nn.utils.rnn.pad_sequence(motions, batch_first=True)  # (B, T, J)
    lengths = torch.tensor([len(motion) for motion in motions])
    mask = (torch.arange(target.shape[1]) < lengths[:, None])[..., None].float()
    return _Bucket(torch.tensor(rows, device=device), target.to(device), mask.to(device))
