"""From the command to a server that serves, against one that loads everything at once.

The plain way imports all that the package has, at the top of every module as usual, and reads all
shipped checkpoints and the robot's meshes before it serves.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time

from timing import Table

from rnnpb_explorer.core.model import RNNPB

TIMES = 3
COMMAND = [sys.executable, "-m", "rnnpb_explorer.app.commands.explorer", "--port", "0"]
HELP = [sys.executable, "-m", "rnnpb_explorer.app.commands.main", "--help"]
EVERYTHING = """
import importlib, pkgutil, rnnpb_explorer
for one in pkgutil.walk_packages(rnnpb_explorer.__path__, "rnnpb_explorer."):
    if "static" not in one.name and not one.name.endswith("__main__"):
        importlib.import_module(one.name)
import sklearn.decomposition, trimesh, yourdfpy, matplotlib.pyplot
from rnnpb_explorer.core.checkpoint import load_checkpoint, shipped_checkpoints
from rnnpb_explorer.app.page.server import ServerOptions, start
names = tuple(shipped_checkpoints())
start(ServerOptions(checkpoints=names, port=0))
print("ready", flush=True)
import os
os._exit(0)
"""


def until_line(command: list[str]) -> float:
    """Seconds until a command says its first line; the fastest of some, files in the cache."""
    times = []
    for _ in range(TIMES + 1):
        began = time.perf_counter()
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=os.environ
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            times.append(time.perf_counter() - began)
            process.kill()
    return min(times[1:])


def run(model: RNNPB) -> Table:
    table = Table("From the command to the first answer", "everything at once", "here")
    plain = until_line([sys.executable, "-c", EVERYTHING])
    table.row("rnnpb-explorer serves", plain, until_line(COMMAND))
    table.row("rnnpb --help", plain, until_line(HELP))
    return table
