"""Running `rnnpb` in this process, on a tiny model and data that fit it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from rnnpb_explorer.app.commands.main import main
from rnnpb_explorer.core import RNNPB, Motion, save_checkpoint, write_motion


@dataclass(frozen=True)
class Outcome:
    code: int
    out: str
    err: str


class Rnnpb:
    """A folder with `tiny.pt` and `data/`, and the command itself."""

    def __init__(self, folder: Path, model: RNNPB, capture: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self.model = model
        self._capture = capture
        save_checkpoint(model, folder / "tiny.pt")
        (folder / "data").mkdir()
        for index, name in enumerate(model.info.motions):
            write_motion(self.target(index), folder / "data" / f"{name}.csv")

    def target(self, index: int) -> Motion:
        """A motion of the right length that is close to, but not, the model's own."""
        info = self.model.info
        positions = self.model.reconstruct(index).numpy()
        swing = 0.1 * np.sin(np.arange(len(positions)) / 2 + index).astype(np.float32)
        return Motion(info.motions[index], info.joints, positions + swing[:, None], info.fps)

    def __call__(self, *flags: object) -> Outcome:
        self._capture.readouterr()
        code = main([str(flag) for flag in flags])
        captured = self._capture.readouterr()
        return Outcome(code, captured.out, captured.err)

    def refuses(self, *flags: object) -> str:
        """The one line in which it says what is wrong."""
        outcome = self(*flags)
        assert outcome.code == 2, outcome
        assert outcome.out == ""
        assert outcome.err.startswith("rnnpb")
        assert outcome.err.count("\n") == 1, outcome.err
        assert "Traceback" not in outcome.err
        return outcome.err.rstrip("\n")
