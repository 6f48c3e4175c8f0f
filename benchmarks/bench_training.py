"""One epoch of training against the published step-by-step code, also held to AVX2.

Most laptops have AVX2 and nothing better. What torch's kernels may use is decided when a process
starts, so that each setting is measured in a process of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import torch
from timing import AVX2, Table, best_of
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from rnnpb_explorer.core import load_checkpoint
from rnnpb_explorer.core.checkpoint import save_checkpoint
from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.model import RNNPB, kl_divergence
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.training import Trainer, TrainingConfig

SETTINGS: dict[str, dict[str, str]] = {
    "this processor": {},
    "held to AVX2": AVX2,
}
FEW = 18  # every 18th motion of 72: as many as a person records in an afternoon
RECIPE = TrainingConfig(epochs=1_000_000)


def own_reconstructions(model: RNNPB) -> Dataset:
    """Motions to learn, of the true lengths, without any data: what the model itself generates."""
    motions = [
        Motion(model.motion_name(i), model.info.joints, model.reconstruct(i).numpy())
        for i in range(model.config.num_motions)
    ]
    return Dataset(tuple(motions), {})


def frame_by_frame(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """(B, T, J): a fused LSTM called once a frame on [previous frame, PB]."""
    weights = (
        torch.cat([model.weight_frame, model.weight_pb], dim=1),
        model.weight_hidden,
        model.bias,
        torch.zeros_like(model.bias),
    )
    h = c = torch.zeros(1, len(pb), model.config.hidden_size)
    frame = torch.zeros(1, len(pb), model.config.num_joints)
    frames = []
    for _ in range(steps):
        inputs = torch.cat([frame, pb[None]], dim=2)
        _, h, c = torch.lstm(inputs, (h, c), weights, True, 1, 0.0, True, False, False)
        frame = h @ model.weight_out.T + model.bias_out
        frames.append(frame)
    return torch.cat(frames).transpose(0, 1)


def published(model: RNNPB, dataset: Dataset) -> Iterator[float]:
    """The published training, an epoch at a time; yields the loss (eq. 3).

    All motions are one batch, padded to the longest; Adam at 0.001 learns everything.
    """
    optimizer = torch.optim.Adam(model.parameters(), 1e-3)
    random = torch.Generator().manual_seed(RECIPE.seed)
    motions = [torch.from_numpy(motion.positions) for motion in dataset.motions]
    target = pad_sequence(motions, batch_first=True)  # (N, T, J)
    lengths = torch.tensor([len(motion) for motion in motions])
    mask = (torch.arange(target.shape[1]) < lengths[:, None])[..., None]
    while True:
        pb = model.mu + model.sigma * torch.randn(model.mu.shape, generator=random)  # eq. 1
        error = (frame_by_frame(model, pb, target.shape[1]) - target) * mask
        loss = error.square().sum() / lengths.sum()
        loss = loss + (model.config.beta or 0.0) * kl_divergence(model.mu, model.log_var)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        yield loss.item()


def measure(dataset: Dataset, model: RNNPB) -> dict[str, float]:
    """Seconds of an epoch either way, and by how much the loss of the first one differs."""
    trainer = Trainer(dataset, model.config, RECIPE)
    fresh = RNNPB(trainer.model.config, trainer.model.info)
    fresh.load_state_dict(trainer.model.state_dict())
    plain, quick = published(fresh, dataset), trainer.run()
    difference = abs(next(plain) - next(quick).loss)
    return {
        "plain": best_of(lambda: next(plain)),
        "quick": best_of(lambda: next(quick)),
        "difference": difference,
    }


def run(model: RNNPB) -> Table:
    frames = sum(model.length(i) for i in range(model.config.num_motions))
    table = Table(
        f"Training, one epoch of {model.config.num_motions} motions, {frames} frames",
        "published",
        "here",
    )
    differences = []
    with tempfile.TemporaryDirectory() as folder:
        checkpoint = Path(folder) / "model.pt"
        save_checkpoint(model, checkpoint)
        for setting, environment in SETTINGS.items():
            outcome = subprocess.run(
                [sys.executable, __file__, checkpoint],
                env=os.environ | environment,
                check=True,
                stdout=subprocess.PIPE,
            )
            for motions, result in json.loads(outcome.stdout).items():
                table.row(f"{motions} motions, {setting}", result["plain"], result["quick"], aim=3)
                differences.append(result["difference"])
    table.note(f"the first epoch's losses differ by {max(differences):.1e} at most")
    return table


def main() -> None:
    """Print the measurements of this process as JSON, by the number of motions."""
    model = load_checkpoint(sys.argv[1])
    dataset = own_reconstructions(model)
    few = replace(dataset, motions=dataset.motions[::FEW])
    print(json.dumps({len(each.motions): measure(each, model) for each in (dataset, few)}))


if __name__ == "__main__":
    main()
