"""Run the benchmarks: `python benchmarks/run.py [--ckpt C] [--write] [NAME...]`.

Each prints the ratio to a plain implementation in the same run: ratios travel between machines
better than seconds do. What computes is measured once more in a process that may use AVX2 and
nothing better, as most processors of users have no more. `--write` puts all into
docs/benchmarks.md, with the machine and the versions.
"""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import torch
from timing import AVX2

from rnnpb_explorer.core import InputError, load_checkpoint

REPORT = Path(__file__).parents[1] / "docs" / "benchmarks.md"
HELD = ("generation", "landscape", "recognition")  # once more with AVX2; training does it itself
PACKAGES = ("torch", "numpy", "viser", "websockets")
HEAD = """# Benchmarks

Written by `make bench ARGS=--write`. Every figure is a ratio to a plain implementation of the same
work in the same run: eqs. 6 to 8 one frame after the other, the published training code, one motion
after the other. "Aim" is what is hoped for where the processor allows. The limit of a machine is
the time that it needs for the bare matrix products.
"""


def main() -> None:
    here = Path(__file__).parent
    known = sorted(path.stem.removeprefix("bench_") for path in here.glob("bench_*.py"))
    parser = argparse.ArgumentParser(description="Measure what is meant to be quick.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(known)}")
    parser.add_argument("--ckpt", default="strong", help="a path or the name of a shipped one")
    parser.add_argument("--write", action="store_true", help="to docs/benchmarks.md as well")
    parser.add_argument("--bare", action="store_true", help=argparse.SUPPRESS)  # what is asked for
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in known:
            parser.error(f"no benchmark {name!r}; there are: {', '.join(known)}")
    if arguments.write and arguments.names:
        parser.error("--write is for all of them")
    try:
        model = load_checkpoint(arguments.ckpt)
    except InputError as error:
        parser.error(str(error))
    machine = machine_line()
    if not arguments.bare:
        print(machine)
    found = []
    for name in arguments.names or known:
        found.append(str(importlib.import_module(f"bench_{name}").run(model)))
        print(found[-1], flush=True)
        if name in HELD and not arguments.bare:
            found.append(held(name, arguments.ckpt))
            print(found[-1], flush=True)
    if arguments.write:
        blocks = "\n".join(f"```\n{one.rstrip()}\n```\n" for one in found)
        REPORT.write_text(f"{HEAD}\n{machine}.\n\n{blocks}", encoding="utf-8")


def held(name: str, checkpoint: str) -> str:
    """The same in a process of its own, held to AVX2: torch decides when it starts."""
    command = [sys.executable, __file__, "--bare", "--ckpt", checkpoint, name]
    outcome = subprocess.run(
        command, env=os.environ | AVX2, check=True, stdout=subprocess.PIPE, text=True
    )
    return f"Held to AVX2: {outcome.stdout.rstrip()}"


def machine_line() -> str:
    """Processor, cores, system and versions."""
    versions = ", ".join(f"{package} {version(package)}" for package in PACKAGES)
    return (
        f"{processor()}, {os.cpu_count()} cores, {torch.get_num_threads()} threads for torch; "
        f"{platform.system()}, Python {platform.python_version()}, {versions}"
    )


def processor() -> str:
    """Its name, where the system says it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.machine()


if __name__ == "__main__":
    main()
