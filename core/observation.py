"""What a recognition sees of a motion: its first frames, all joints or some of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from .batching import chunks
from .errors import InputError
from .model import RNNPB
from .verdict import STILL


@dataclass(frozen=True, eq=False)
class Observation:
    """
    target: (T, J), on the model's device; what is not observed is only scored.
    frames: that are observed, from the first. joints: (O,) indices of those that are.
    """

    target: Tensor
    frames: int
    joints: Tensor

    @classmethod
    def of(
        cls, model: RNNPB, target: ArrayLike, observed: float = 1.0, joints: Sequence[int] = ()
    ) -> Observation:
        """The first int(observed * T) frames of a motion (T, J); no `joints` means all.

        Raises:
            InputError: a target of another number of joints, too short, or not finite; a joint that
                the model does not have.
        """
        motion = torch.as_tensor(np.array(target, dtype=np.float32)).to(model.mu)
        count = model.config.num_joints
        if motion.ndim != 2 or motion.shape[1] != count:
            raise InputError(
                f"the target has shape {tuple(motion.shape)}, the model generates (frames, {count})"
            )
        frames = int(observed * len(motion))
        if frames < 1:
            raise InputError(f"{observed} of {len(motion)} frames leaves none to observe")
        if not torch.isfinite(motion).all():
            raise InputError("the target holds NaN or infinity")
        chosen = sorted(set(joints)) or range(count)
        if min(chosen) < 0 or max(chosen) >= count:
            raise InputError(f"the model has the joints 0 to {count - 1}, not {max(chosen)}")
        with torch.inference_mode(False):  # a gradient goes through these even where none is asked
            return cls(motion.clone(), frames, torch.tensor(chosen, device=motion.device))

    def seen(self, motions: Tensor) -> Tensor:
        """(..., frames, O) the observed part of motions (..., T, J)."""
        return motions[..., : self.frames, :].index_select(-1, self.joints)

    def losses(self, motions: Tensor) -> Tensor:
        """(B,) squared errors of motions (B, T, J), averaged over what is observed (eq. 10)."""
        return (self.seen(motions) - self.seen(self.target)).square().mean(dim=(1, 2))

    def prediction_errors(self, motions: Tensor) -> Tensor:
        """(B,) the same in the frames that are not observed; NaN where all are."""
        later = (motions - self.target)[:, self.frames :].index_select(-1, self.joints)
        return later.square().mean(dim=(1, 2))

    def explained(self, losses: Tensor) -> Tensor:
        """(B,) shares of the observed part's variance; NaN where nothing moves there.

        1 for a perfect motion, 0 for one that does no better than the mean posture.
        """
        seen = self.seen(self.target)
        variance = float((seen - seen.mean(dim=0)).square().mean())
        return 1 - losses / (variance if variance >= STILL else torch.nan)

    @torch.no_grad()
    def losses_of(self, model: RNNPB, pbs: Tensor) -> Tensor:
        """(B,) losses of the motions of PBs (B, D), generated in parts."""
        parts = chunks(pbs, self.frames)
        return torch.cat([self.losses(model.generate(part, self.frames)) for part in parts])
