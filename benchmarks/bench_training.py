"""One epoch of training: buckets and folded recurrence against the published step-by-step code."""

from __future__ import annotations

import torch
from timing import Table, best_of
from torch import Tensor
from torch.nn.utils.rnn import pad_sequence

from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.training import Trainer, TrainingConfig


def own_reconstructions(model: RNNPB) -> Dataset:
    """Motions to learn, of the true lengths, without any data: what the model itself generates."""
    motions = [
        Motion(model.motion_name(i), model.info.joints, model.reconstruct(i).numpy())
        for i in range(model.config.num_motions)
    ]
    return Dataset(tuple(motions), {})


def frame_by_frame(model: RNNPB, pb: Tensor, steps: int) -> Tensor:
    """As the published code does it: a fused LSTM called once a frame on [previous frame, PB]."""
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


class PaddedTrainer(Trainer):
    """All motions as one batch, padded to the longest, generated one frame after the other."""

    def _backward_error(self, pb: Tensor) -> float:
        targets = [
            target[: int(mask.sum())]
            for bucket in self._buckets
            for target, mask in zip(bucket.target, bucket.mask, strict=True)
        ]
        lengths = torch.tensor([len(target) for target in targets])
        target = pad_sequence(targets, batch_first=True)  # (N, T, J)
        mask = torch.arange(target.shape[1]) < lengths[:, None]
        rows = torch.cat([bucket.rows for bucket in self._buckets])
        (sample,) = pb  # (N, D), one for each motion
        generated = frame_by_frame(self.model, sample[rows], target.shape[1])
        loss = ((generated - target) * mask[..., None]).square().sum() / self._frames
        loss.backward()
        return loss.item()


def run(model: RNNPB) -> Table:
    dataset = own_reconstructions(model)
    frames = sum(len(motion) for motion in dataset.motions)
    table = Table(
        f"Training, one epoch of {len(dataset.motions)} motions, {frames} frames",
        "padded, by frame",
        "buckets, folded",
    )
    recipe = TrainingConfig(epochs=1_000_000)
    plain = PaddedTrainer(dataset, model.config, recipe).run()
    quick = Trainer(dataset, model.config, recipe).run()
    next(plain), next(quick)
    difference = abs(next(plain).loss - next(quick).loss)
    table.row("epoch", best_of(lambda: next(plain)), best_of(lambda: next(quick)))
    table.note(f"difference of the second epoch's loss {difference:.1e}")
    return table
