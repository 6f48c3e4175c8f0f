"""The files that a motion for a robot is written to and read from."""

from __future__ import annotations

from typing import Literal, get_args

Format = Literal["csv", "json", "naoqi"]
FORMATS: tuple[Format, ...] = get_args(Format)
JSON_FORMAT = "rnnpb-motion"  # what a JSON file says it is
