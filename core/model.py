"""The stochastic RNNPB: an LSTM that generates a whole motion from one small vector, the PB.

Hwang and Ahmadi, "A Novel Framework for Learning Stochastic Representations for Sequence
Generation and Recognition", section III. The shapes in the comments: B sequences, T frames,
J joints, D = D_PB, H hidden units, N training motions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import torch
from torch import Tensor, nn

from .errors import InputError
from .motion import MotionLabel

Behavior = Literal["stochastic", "deterministic"]


@dataclass(frozen=True)
class ModelConfig:
    """The size and kind of a network; enough to build it, without any flag."""

    num_joints: int = 17
    pb_dim: int = 4
    hidden_size: int = 256
    num_motions: int = 72
    behavior: Behavior = "stochastic"
    beta: float | None = 1e-3  # weight of the KL term (eq. 3); None when deterministic

    def __post_init__(self) -> None:
        sizes = (self.num_joints, self.pb_dim, self.hidden_size, self.num_motions)
        if min(sizes) < 1:
            raise InputError(f"every size of a model must be at least 1, got {sizes}")
        if self.behavior not in ("stochastic", "deterministic"):
            raise InputError(f"behavior must be stochastic or deterministic, got {self.behavior!r}")
        if self.behavior == "stochastic" and not (self.beta is not None and self.beta >= 0):
            raise InputError(f"beta must be a number of at least 0, got {self.beta}")


@dataclass
class ModelInfo:
    """What a network cannot know of itself: names, rate, and where it comes from."""

    joints: tuple[str, ...]
    fps: float = 25.0
    motions: tuple[str, ...] = ()  # in the order of mu's rows
    lengths: tuple[int, ...] = ()  # frames
    labels: dict[str, MotionLabel] = field(default_factory=dict)  # by motion name
    training: dict[str, float | int | str] = field(default_factory=dict)
    metrics: dict[str, float] = field(default_factory=dict)
    attribution: str = ""


class RNNPB(nn.Module):
    """Network and learned PBs of N motions.

    ``mu`` (N, D) and ``sigma`` (N, D) are the Gaussians of section III.A, one a motion.
    """

    def __init__(self, config: ModelConfig, info: ModelInfo) -> None:
        super().__init__()
        self.config = config
        self.info = info
        hidden, joints, pb_dim = config.hidden_size, config.num_joints, config.pb_dim
        self.mu = nn.Parameter(torch.zeros(config.num_motions, pb_dim))
        self.log_var = nn.Parameter(torch.zeros(config.num_motions, pb_dim))  # log sigma^2
        # The gates' weights on the previous frame, on the PB and on the hidden state are kept
        # apart because folding (below) treats each differently. Gate order: i, f, g, o.
        self.weight_frame = nn.Parameter(torch.empty(4 * hidden, joints))
        self.weight_pb = nn.Parameter(torch.empty(4 * hidden, pb_dim))
        self.weight_hidden = nn.Parameter(torch.empty(4 * hidden, hidden))
        self.bias = nn.Parameter(torch.empty(4 * hidden))
        self.weight_out = nn.Parameter(torch.empty(joints, hidden))
        self.bias_out = nn.Parameter(torch.empty(joints))
        for parameter in self.network_parameters():  # as torch's own LSTM and Linear start
            nn.init.uniform_(parameter, -(hidden**-0.5), hidden**-0.5)

    def network_parameters(self) -> tuple[nn.Parameter, ...]:
        return (
            self.weight_frame,
            self.weight_pb,
            self.weight_hidden,
            self.bias,
            self.weight_out,
            self.bias_out,
        )

    @property
    def stochastic(self) -> bool:
        return self.config.behavior == "stochastic"

    @property
    def sigma(self) -> Tensor:
        """(N, D) standard deviations of the learned PBs; zeros in a deterministic model."""
        if not self.stochastic:
            return torch.zeros_like(self.mu)
        return torch.exp(0.5 * self.log_var)

    def generate(self, pb: Tensor, steps: int) -> Tensor:
        """Closed-loop generation (eqs. 6 to 8), differentiable with respect to everything.

        The previous output is a linear function of the hidden state, so feeding it back is part of
        an ordinary recurrence with folded weights, W_hidden + W_frame W_out, whose only input is
        the PB. That lets one fused kernel run the whole sequence. The first step stands
        apart: its previous frame is 0, not the read-out of a hidden state.

        Args:
            pb: (B, D), one PB a sequence; or (T, B, D), one a frame.
            steps: T, frames to generate, at least 1.

        Returns:
            (B, T, J) joint values, radians (openings from 0 to 1 for Pepper's hands).
        """
        (whole,) = self.generate_in_parts(pb, steps, steps)
        return whole

    def generate_in_parts(self, pb: Tensor, steps: int, at_once: int) -> Iterator[Tensor]:
        """The same as parts (B, t, J) of at most `at_once` frames, one after the other."""
        hidden = self.config.hidden_size
        pb = pb.expand(steps, -1, -1)  # (T, B, D)
        gates = pb[0] @ self.weight_pb.T + self.bias  # (B, 4H); x_0 = h_0 = 0
        i, _, g, o = gates.split(hidden, dim=-1)
        c = torch.sigmoid(i) * torch.tanh(g)  # c_0 = 0: nothing to forget
        h = torch.sigmoid(o) * torch.tanh(c)  # (B, H)
        outputs, state = h[None], (h[None], c[None])  # (1, B, H)
        folded = (
            self.weight_pb,
            self.weight_hidden + self.weight_frame @ self.weight_out,
            self.bias + self.weight_frame @ self.bias_out,
            torch.zeros_like(self.bias),
        )
        for first in range(0, steps, at_once):
            start = max(first, 1)  # the first frame is there
            count = min(first + at_once, steps) - start
            if count:
                # What nn.LSTM calls, without a module: several threads may generate at once.
                rest, h_n, c_n = torch.lstm(
                    pb[start : start + count].contiguous(),  # (t, B, D)
                    state,
                    folded,
                    has_biases=True,
                    num_layers=1,
                    dropout=0.0,
                    train=torch.is_grad_enabled(),
                    bidirectional=False,
                    batch_first=False,
                )
                state = (h_n, c_n)
                outputs = rest if first else torch.cat([outputs, rest])  # (t, B, H)
            yield (outputs @ self.weight_out.T + self.bias_out).transpose(0, 1)  # (B, t, J)

    def generate_stepwise(self, pb: Tensor, steps: int) -> Tensor:
        """What `generate` does as eqs. 6 to 8 say it, one frame after the other; slow.

        Args:
            pb: (..., D), one PB a sequence.

        Returns:
            (..., T, J) joint values.
        """
        weight_input = torch.cat([self.weight_pb, self.weight_frame], dim=1)  # (4H, D + J)
        x = pb.new_zeros(*pb.shape[:-1], self.config.num_joints)  # (..., J)
        h = c = pb.new_zeros(*pb.shape[:-1], self.config.hidden_size)  # (..., H)
        frames = []
        for _ in range(steps):
            z = torch.cat([pb, x], dim=-1)  # eq. 6
            gates = z @ weight_input.T + h @ self.weight_hidden.T + self.bias  # eq. 7
            i, f, g, o = gates.chunk(4, dim=-1)
            c = torch.sigmoid(f) * c + torch.sigmoid(i) * torch.tanh(g)
            h = torch.sigmoid(o) * torch.tanh(c)
            x = h @ self.weight_out.T + self.bias_out  # eq. 8
            frames.append(x)
        return torch.stack(frames, dim=-2)

    @torch.no_grad()
    def reconstruct(self, index: int, steps: int | None = None) -> Tensor:
        """(T, J): motion `index` from its learned mu at sigma = 0."""
        return self.generate(self.mu[index : index + 1], steps or self.length(index))[0]

    def length(self, index: int) -> int:
        """Frames of motion `index`; 150 where the checkpoint does not say."""
        return self.info.lengths[index] if self.info.lengths else UNKNOWN_LENGTH

    def motion_index(self, name: str) -> int:
        """The row of a motion given by name or by index from 0.

        Raises:
            InputError: there is no such motion; the message lists those there are.
        """
        if name in self.info.motions:
            return self.info.motions.index(name)
        if name.isdecimal() and int(name) < self.config.num_motions:
            return int(name)
        known = ", ".join(self.info.motions) or f"indices 0 to {self.config.num_motions - 1}"
        raise InputError(f"no motion {name!r} in this model; there are: {known}")

    def motion_name(self, index: int) -> str:
        return self.info.motions[index] if self.info.motions else f"motion {index}"


UNKNOWN_LENGTH = 150  # frames of a motion of a published checkpoint, which carries no lengths


def kl_divergence(mu: Tensor, log_var: Tensor) -> Tensor:
    """KL(N(mu, sigma^2) || N(0, 1)) summed over sequences and dimensions (eq. 5, without 1/N).

    The published code sums where the paper writes a mean; the paper's beta and error belong to the
    sum.
    """
    return 0.5 * (mu.square() + log_var.exp() - 1 - log_var).sum()


def gaussian_kl(mu: Tensor, sigma: Tensor) -> Tensor:
    """(B,) the same for each of B Gaussians (B, D), given their sigma; infinite where it is."""
    return 0.5 * (mu.square() + sigma.square() - 1 - 2 * sigma.log()).sum(dim=1)
