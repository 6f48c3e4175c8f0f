"""Run the benchmarks: `python benchmarks/run.py [--ckpt C] [NAME...]`.

Each prints the ratio to a plain implementation in the same run: ratios travel between machines
better than seconds do.
"""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

import torch

from rnnpb_explorer.core import InputError, load_checkpoint


def main() -> None:
    here = Path(__file__).parent
    known = sorted(path.stem.removeprefix("bench_") for path in here.glob("bench_*.py"))
    parser = argparse.ArgumentParser(description="Measure what is meant to be quick.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(known)}")
    parser.add_argument("--ckpt", default="strong", help="a path or the name of a shipped one")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in known:
            parser.error(f"no benchmark {name!r}; there are: {', '.join(known)}")
    try:
        model = load_checkpoint(arguments.ckpt)
    except InputError as error:
        parser.error(str(error))
    print(f"torch {torch.__version__}, {torch.get_num_threads()} threads")
    for name in arguments.names or known:
        print(importlib.import_module(f"bench_{name}").run(model), flush=True)


if __name__ == "__main__":
    main()
