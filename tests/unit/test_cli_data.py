"""`rnnpb data`: fetched over a real (local) HTTP server, or taken from a folder."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from rnnpb_explorer.core.files import CACHE_VARIABLE
from rnnpb_explorer.robot import rebl_pepper
from rnnpb_explorer.robot.rebl_pepper import BASE_URL, SHA256, take

from .cli_harness import Rnnpb

CONTENT = {"data_raw.csv": b",id\n", "labels_augmented.csv": b",id,valence,arousal\n"}


@pytest.fixture
def published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder that a server on this machine publishes; what it holds is what is expected."""
    folder = tmp_path / "published"
    folder.mkdir()
    for name, content in CONTENT.items():
        (folder / name).write_bytes(content)
        monkeypatch.setitem(SHA256, name, hashlib.sha256(content).hexdigest())

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, format: str, *arguments: object) -> None:
            requested.append(self.path)

    requested: list[str] = []
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setattr(rebl_pepper, "BASE_URL", f"http://127.0.0.1:{server.server_port}/")
    monkeypatch.setattr(rebl_pepper, "RETRIES", 0)
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    yield folder
    server.shutdown()
    thread.join()
    server.server_close()


def test_fetches_into_the_cache(rnnpb: Rnnpb, published: Path) -> None:
    outcome = rnnpb("data")
    assert outcome.code == 0, outcome
    folder = Path(outcome.out.strip())  # the folder and nothing else: for "$(rnnpb data)"
    assert folder == rnnpb.folder / "cache"
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == CONTENT
    for words in ("CC BY 4.0", "Please cite", "https://doi.org/10.1145/3371382.3378360"):
        assert words in outcome.err


def test_fetches_only_what_is_missing_or_damaged(rnnpb: Rnnpb, published: Path) -> None:
    assert rnnpb("data").code == 0
    damaged = rnnpb.folder / "cache" / "data_raw.csv"
    damaged.write_text("half of it")
    (published / "labels_augmented.csv").unlink()  # in the cache already, so nobody asks for it
    assert rnnpb("data").code == 0
    assert damaged.read_bytes() == CONTENT["data_raw.csv"]


def test_refuses_another_file_than_expected(rnnpb: Rnnpb, published: Path) -> None:
    (published / "data_raw.csv").write_text("something else")
    said = rnnpb.refuses("data")
    assert "data_raw.csv is not the file that was expected: its SHA-256 is not" in said
    assert not (rnnpb.folder / "cache" / "data_raw.csv").exists()


def test_without_a_connection(rnnpb: Rnnpb, published: Path) -> None:
    (published / "data_raw.csv").unlink()  # 404
    said = rnnpb.refuses("data")
    assert "cannot fetch http://127.0.0.1" in said
    assert "rnnpb data --path FOLDER takes them from there" in said


@pytest.mark.parametrize("given", ["", "data_raw.csv", "clone"])
def test_takes_them_from_a_folder(rnnpb: Rnnpb, published: Path, given: str) -> None:
    path = published / given
    if given == "clone":
        path = rnnpb.folder / "clone"
        path.mkdir()
        published.rename(path / "original_animations")
    outcome = rnnpb("data", "--path", path)
    assert (outcome.code, outcome.out.strip()) == (0, str(rnnpb.folder / "cache"))
    assert {p.name: p.read_bytes() for p in (rnnpb.folder / "cache").iterdir()} == CONTENT


def test_takes_nothing_else(rnnpb: Rnnpb, published: Path) -> None:
    assert "there is no data_raw.csv in " in rnnpb.refuses("data", "--path", "data")
    (published / "labels_augmented.csv").write_text("mine")
    said = rnnpb.refuses("data", "--path", published)
    assert "labels_augmented.csv is not the published file: its SHA-256 is not" in said
    assert not (rnnpb.folder / "cache").exists()


def test_a_cache_that_cannot_be_written(
    rnnpb: Rnnpb, published: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(rnnpb.folder / "tiny.pt" / "cache"))
    assert "cannot " in rnnpb.refuses("data")
    assert "cannot make the folder" in rnnpb.refuses("data", "--path", published)


def test_what_is_pinned(shared_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The real files have the pinned check sums; the address names one commit, not a branch."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    take(shared_dir / "data" / "rebl-pepper")
    assert (tmp_path / "data_raw.csv").stat().st_size == 2_416_234
    commit = BASE_URL.split("/")[-3]
    assert len(commit) == 40
    assert all(len(digest) == 64 for digest in SHA256.values())
