"""A disk that is full while a file is written: one line, and what lay there is kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from .cli_harness import Rnnpb
from .full_disk import full_disk

RECIPE = ("--pb-dim", 2, "--hidden-size", 8, "--epochs", 2)


@pytest.mark.parametrize(
    "flags",
    [
        ("export", "--ckpt", "tiny.pt", "--motion", "wave", "--format", "json"),
        ("generate", "--ckpt", "tiny.pt", "--motion", "wave"),
        ("landscape", "--ckpt", "tiny.pt", "--motion", "wave"),
        ("train", "--data", "data", *RECIPE),
    ],
    ids=lambda flags: str(flags[0]),
)
def test_what_lay_there_is_kept(rnnpb: Rnnpb, flags: tuple[object, ...]) -> None:
    suffix = {"export": "json", "generate": "csv", "landscape": "npz", "train": "pt"}
    out = Path(f"out.{suffix[str(flags[0])]}")
    out.write_bytes(b"before")
    with full_disk(200):
        outcome = rnnpb(*flags, "--out", out)
    assert outcome.code not in (0, None)
    assert f"cannot write {out.resolve()}" in outcome.err
    assert "Traceback" not in outcome.err
    assert out.read_bytes() == b"before"
    assert [one.name for one in Path().glob("*out*")] + [
        one.name for one in Path().glob(".*out*")
    ] == [out.name]
