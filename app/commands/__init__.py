"""The commands of `rnnpb`, one module each, in the order in which the help lists them."""

from __future__ import annotations

from . import data, evaluate, figures, generate, info, landscape, recognize, sweep, train

COMMANDS = (
    info.COMMAND,
    generate.COMMAND,
    landscape.COMMAND,
    recognize.COMMAND,
    train.COMMAND,
    evaluate.COMMAND,
    sweep.COMMAND,
    figures.COMMAND,
    data.COMMAND,
)
