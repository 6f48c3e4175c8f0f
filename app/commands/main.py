"""`rnnpb`: the explorer's work without a browser; every command is the module of its name."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from .answer import answer, make_app

# In the order in which the help lists them.
COMMANDS = {
    "info": "Show what a checkpoint holds.",
    "generate": "Generate motions from a PB.",
    "landscape": "Correlate motions around a learned PB with a target.",
    "recognize": "Find the PB that explains a motion.",
    "follow": "Recognise a motion while it arrives.",
    "convert": "Read a motion file of any kind, and write it as one of our own.",
    "train": "Train a model on motions.",
    "evaluate": "Measure checkpoints as the paper does.",
    "compare": "Measure how smooth latent spaces are, side by side.",
    "sweep": "Train and measure every model of Table I.",
    "figures": "Draw the paper's Figs. 2 to 6.",
    "data": "Fetch the REBL-Pepper motions into the user's cache.",
    "robot": "Show what a robot description holds.",
    "export": "Write a motion for a real robot.",
    "screenshot": "Take a picture of the app, as a person would see it.",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code; nothing is raised for bad input."""
    app = make_app("rnnpb", "Stochastic RNNPB models without a browser.")
    for place, (name, summary) in enumerate(COMMANDS.items()):
        # By its path: a command's module is imported when it is asked for.
        app.command(f"{__package__}.{name}:run", name=name, help=summary, sort_key=place)
    return answer(app, argv)


if __name__ == "__main__":
    sys.exit(main())
