"""`rnnpb sweep` in the kernel: `python scripts/fast_training/sweep.py --data D --out DIR ...`.

Takes the flags of `rnnpb sweep`; all cells run in this one process, on one core. They are kept
apart from those of `rnnpb sweep`: the precision is part of a cell's recipe.
"""

from __future__ import annotations

import sys

from packed_lstm import PackedTrainer

from rnnpb_explorer.app.commands.main import main
from rnnpb_explorer.core import training

if __name__ == "__main__":
    training.Trainer = PackedTrainer  # what a cell looks up when it runs
    sys.exit(main(["sweep", *sys.argv[1:], "--jobs", "1", "--device", "cpu"]))
