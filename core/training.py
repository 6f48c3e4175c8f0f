"""Training: network weights and PBs together, by closed-loop generation (section III.B).

The recipe differs from the published one (50,000 epochs of Adam at 0.001 for everything) where that
is slow: motions run in buckets of similar length, so that no work goes into padding; each PB learns
from its own motion only and gets a higher rate; the rate falls along a cosine.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import torch
from torch import Tensor

from .data import Dataset
from .errors import InputError
from .model import ModelConfig, ModelInfo, RNNPB, kl_divergence


@dataclass(frozen=True)
class TrainingConfig:
    """A recipe; the defaults are the one the shipped checkpoints were trained with."""

    epochs: int = 6000
    seed: int = 0
    learning_rate: float = 5e-3  # network weights
    pb_rate_factor: float = 4.0  # PB parameters learn this much faster
    beta2: float = 0.98
    max_gradient_norm: float = 1.0
    warm_up_epochs: int = 50
    max_bucket_padding: float = 0.05  # frames of padding a bucket may hold, as a share

    def __post_init__(self) -> None:
        if self.epochs < 1:
            raise InputError(f"epochs must be at least 1, got {self.epochs}")


@dataclass(frozen=True)
class TrainingProgress:
    """One finished epoch."""

    epoch: int  # 1 .. epochs
    epochs: int
    loss: float  # eq. 3, as the published code sums it
    error: float  # squared error averaged over frames and joints, at the sampled PBs
    kl: float  # summed over sequences and dimensions
    seconds: float  # since this run began

    @property
    def seconds_left(self) -> float:
        return 0.0


@dataclass(frozen=True)
class _Bucket:
    rows: Tensor  # (B,) indices of motions
    target: Tensor  # (B, T, J), zero-padded
    mask: Tensor  # (B, T, 1), 1 where a frame is real


class Trainer:
    """One training run, an epoch at a time.

    >>> trainer = Trainer(dataset, ModelConfig(), TrainingConfig())  # doctest: +SKIP
    >>> for progress in trainer.run():  # doctest: +SKIP
    ...     print(progress.error)
    """

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
        self._buckets = _make_buckets(dataset, training.max_bucket_padding, device)
        self._frames = sum(len(motion) for motion in dataset.motions)
        pb_parameters = [self.model.mu]
        if self.model.stochastic:
            pb_parameters.append(self.model.log_var)
        self._optimizer = torch.optim.Adam(
            [
                {"params": pb_parameters, "lr": training.learning_rate * training.pb_rate_factor},
                {"params": self.model.network_parameters(), "lr": training.learning_rate},
            ],
            betas=(0.9, training.beta2),
        )
        self._schedule = torch.optim.lr_scheduler.LambdaLR(self._optimizer, self._rate)

    def _rate(self, epoch: int) -> float:
        warm_up = min(1.0, (epoch + 1) / self.training.warm_up_epochs)
        return warm_up * 0.5 * (1 + math.cos(math.pi * epoch / self.training.epochs))

    def run(self) -> Iterator[TrainingProgress]:
        """Train to the last epoch; stop iterating to interrupt."""
        started = time.monotonic()
        while self.epoch < self.training.epochs:
            error, kl = self._train_epoch()
            self.epoch += 1
            beta = self.model.config.beta or 0.0
            yield TrainingProgress(
                epoch=self.epoch,
                epochs=self.training.epochs,
                loss=error * self.model.config.num_joints + beta * kl,
                error=error,
                kl=kl,
                seconds=time.monotonic() - started,
            )

    def _train_epoch(self) -> tuple[float, float]:
        model = self.model
        self._optimizer.zero_grad()
        pb, kl = model.mu, torch.zeros(())
        if model.stochastic:
            noise = torch.randn(model.mu.shape, generator=self._random).to(model.mu.device)
            pb = model.mu + torch.exp(0.5 * model.log_var) * noise  # eq. 1
            kl = kl_divergence(model.mu, model.log_var)
            (kl * (model.config.beta or 0.0)).backward()
        # Backward bucket by bucket holds one bucket's activations at a time. The PBs are cut off
        # from the graph so that their sampling is run backward only once, at the end.
        leaf = pb.detach().requires_grad_()
        squared_error = 0.0
        for bucket in self._buckets:
            generated = model.generate(leaf[bucket.rows], bucket.target.shape[1])
            loss = ((generated - bucket.target) * bucket.mask).square().sum() / self._frames
            loss.backward()
            squared_error += loss.item()
        pb.backward(leaf.grad)
        torch.nn.utils.clip_grad_norm_(model.parameters(), self.training.max_gradient_norm)
        self._optimizer.step()
        self._schedule.step()
        return squared_error / model.config.num_joints, kl.item()

    def state(self) -> dict[str, Any]:
        """What `restore` needs to go on bit for bit, besides the model."""
        return {
            "training": asdict(self.training),
            "epoch": self.epoch,
            "optimizer": self._optimizer.state_dict(),
            "schedule": self._schedule.state_dict(),
            "random": self._random.get_state(),
        }

    def restore(self, model: RNNPB, state: dict[str, Any]) -> None:
        """Go on from a checkpoint's model and its `state()`.

        Raises:
            InputError: the checkpoint belongs to another model, other data or another recipe.
        """
        if state.get("training") != asdict(self.training):
            raise InputError("the checkpoint was trained with another recipe, seed or epoch count")
        if model.config != self.model.config or model.info.motions != self.model.info.motions:
            raise InputError("the checkpoint belongs to another model or other data")
        self.model.load_state_dict(model.state_dict())
        self._optimizer.load_state_dict(state["optimizer"])
        self._schedule.load_state_dict(state["schedule"])
        self._random.set_state(state["random"])
        self.epoch = int(state["epoch"])


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


def _make_bucket(
    dataset: Dataset, rows: Sequence[int], device: torch.device | str
) -> _Bucket:
    motions = [torch.from_numpy(dataset.motions[row].positions) for row in rows]
    target = torch.nn.utils.rnn.pad_sequence(motions, batch_first=True)  # (B, T, J)
    lengths = torch.tensor([len(motion) for motion in motions])
    mask = (torch.arange(target.shape[1]) < lengths[:, None])[..., None].float()
    return _Bucket(torch.tensor(rows, device=device), target.to(device), mask.to(device))
