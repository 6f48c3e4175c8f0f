"""What the server loads, serves and refuses; no browser is needed."""

from __future__ import annotations

import socket
import sys
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from rnnpb_explorer.app.page.library import model_names
from rnnpb_explorer.app.page.server import (
    App,
    ServerOptions,
    liveliest,
    open_library,
    opening,
    start,
    unmatched_joints,
)
from rnnpb_explorer.app.state import intents as do
from rnnpb_explorer.app.state.document import MAX_MODELS, Document
from rnnpb_explorer.app.state.facts import Facts
from rnnpb_explorer.app.state.statecode import encode
from rnnpb_explorer.core.checkpoint import save_checkpoint, shipped_checkpoints
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.model import RNNPB, ModelInfo
from rnnpb_explorer.core.motion import Motion, MotionLabel, write_motion
from rnnpb_explorer.robot.description import load_robot

from ..app_states import after, make_target


@pytest.fixture
def checkpoint(tiny_model: RNNPB, tmp_path: Path) -> str:
    path = tmp_path / "tiny.pt"
    save_checkpoint(tiny_model, path)
    return str(path)


@pytest.fixture
def options(checkpoint: str) -> ServerOptions:
    return ServerOptions(checkpoints=(checkpoint,), port=0)


def facts_of(model: RNNPB, options: ServerOptions) -> Facts:
    """What a server knows of this model."""
    save_checkpoint(model, options.checkpoints[0])
    return open_library(options).started


def opened(options: ServerOptions) -> Document:
    return opening(open_library(options), options)


@pytest.fixture
def nameless(tiny_model: RNNPB) -> RNNPB:
    """As a published checkpoint: it knows neither names nor lengths."""
    tiny_model.info = ModelInfo(joints=tiny_model.info.joints, fps=20.0)
    return tiny_model


@pytest.fixture
def data_folder(tiny_model: RNNPB, tmp_path: Path) -> Path:
    """A folder of one CSV a motion, of which the model has learnt two by these names."""
    folder = tmp_path / "data"
    folder.mkdir()
    for name, frames in (("bow", 9), ("rest", 14), ("unknown", 11)):
        positions = np.full((frames, 5), 0.5, np.float32) * np.arange(1, frames + 1)[:, None] / 20
        motion = Motion(name, tiny_model.info.joints, positions.astype(np.float32))
        write_motion(motion, folder / f"{name}.csv")
    return folder


def taken_port() -> tuple[socket.socket, int]:
    held = socket.socket()
    held.bind(("127.0.0.1", 0))
    held.listen()
    return held, held.getsockname()[1]


# --- serving ---
@pytest.fixture
def app(options: ServerOptions) -> Iterator[App]:
    running = start(options)
    yield running
    running.stop()


def test_the_page_is_served_at_the_url(app: App) -> None:
    with urllib.request.urlopen(app.url, timeout=20) as response:
        assert response.status == 200
        assert b"<html" in response.read().lower()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has all of 127.0.0.0/8")
def test_nobody_else_is_served_unless_asked(app: App) -> None:
    port = int(app.url.rpartition(":")[2])
    with pytest.raises(OSError):  # noqa: PT011 - which one depends on the machine
        socket.create_connection(("127.0.0.2", port), timeout=20).close()


def test_serving_everybody_names_a_url_that_works_here(options: ServerOptions) -> None:
    running = start(replace(options, host="0.0.0.0", no_token=True))
    try:
        assert running.url.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(running.url, timeout=20) as response:
            assert response.status == 200
    finally:
        running.stop()


def test_a_port_in_use_is_refused_and_never_another_one_taken(options: ServerOptions) -> None:
    held, port = taken_port()
    with held, pytest.raises(InputError, match=f"127.0.0.1:{port}.*--port") as refused:
        start(replace(options, port=port))
    assert "\n" not in str(refused.value)


def test_the_port_asked_for_is_the_port_served(options: ServerOptions) -> None:
    held, port = taken_port()
    held.close()
    running = start(replace(options, port=port))
    try:
        assert running.url == f"http://127.0.0.1:{port}"
    finally:
        running.stop()


def test_two_servers_take_two_free_ports(options: ServerOptions) -> None:
    first, second = start(options), start(options)
    try:
        assert first.url != second.url
    finally:
        first.stop()
        second.stop()


@pytest.mark.parametrize("host", ["256.1.1.1", "no-such-host.invalid"])
@pytest.mark.parametrize("port", [0, 48080])
def test_a_host_that_is_none_is_refused(options: ServerOptions, host: str, port: int) -> None:
    with pytest.raises(InputError, match="--host"):
        start(replace(options, host=host, port=port, no_token=True))


# --- models ---
def test_an_unknown_checkpoint_is_answered_by_what_there_is() -> None:
    with pytest.raises(InputError, match="no checkpoint 'nope'") as refused:
        start(ServerOptions(checkpoints=("nope",), port=0))
    for name in shipped_checkpoints():
        assert f"{name}.pt" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_shipped_checkpoint_opens_by_default() -> None:
    if "strong" not in shipped_checkpoints():
        pytest.skip("checkpoints/strong.pt is not there")
    running = start(ServerOptions(port=0))
    try:
        (facts,) = running.facts
        assert facts.name == "strong"
        assert len(facts.joints) == 17
        assert len(facts.motions) == 72
        assert unmatched_joints(running.robot, running.facts) == []
    finally:
        running.stop()


@pytest.mark.parametrize("count", [0, MAX_MODELS + 1])
def test_no_model_and_too_many_are_refused(checkpoint: str, count: int) -> None:
    with pytest.raises(InputError, match=f"from 1 to {MAX_MODELS} checkpoints, got {count}"):
        open_library(ServerOptions(checkpoints=(checkpoint,) * count))


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device here")
def test_a_device_that_there_is_not_is_refused(options: ServerOptions) -> None:
    with pytest.raises(InputError, match="auto or cpu will do"):
        open_library(replace(options, device="cuda"))


def test_models_are_called_by_their_files() -> None:
    assert model_names(("a/strong.pt", "weak")) == ["strong", "weak"]
    assert model_names(("a/model.tar", "b/model.tar")) == ["a", "b"]
    assert model_names(("a/model.tar",)) == ["a"]
    twice = model_names(("a/x.pt", "a/x.pt", "b/x.pt"))
    assert len(set(twice)) == 3


# --- models that pages open ---
def test_the_shipped_models_and_those_of_a_folder_can_be_opened(
    options: ServerOptions, tiny_model: RNNPB, tmp_path: Path
) -> None:
    folder = tmp_path / "mine"
    (folder / "published").mkdir(parents=True)
    save_checkpoint(tiny_model, folder / "own.pt")
    save_checkpoint(tiny_model, folder / "strong.pt")
    save_checkpoint(tiny_model, folder / "published" / "model.tar")
    (folder / "notes.txt").write_text("no model")
    (folder / "elsewhere.pt").symlink_to(options.checkpoints[0])
    library = open_library(replace(options, models=str(folder)))
    shipped = set(shipped_checkpoints())
    assert set(library.offers()) == shipped | {"tiny", "own", "strong (2)", "published"}
    one, other = library.facts(["own", "strong"])
    assert (one.name, one.motions) == ("own", ("wave", "bow", "rest"))
    assert len(other.motions) == 72
    assert library.facts(["own"])[0] is one  # loaded once
    assert library.models["own"].config == tiny_model.config
    save_checkpoint(tiny_model, folder / "later.pt")
    assert "later" in library.offers()


@pytest.mark.parametrize("name", ["nope", "../tiny", "mine/own", "", "/etc/passwd", "own.pt"])
def test_a_name_is_looked_up_and_never_a_path(
    options: ServerOptions, tiny_model: RNNPB, tmp_path: Path, name: str
) -> None:
    (tmp_path / "mine").mkdir()
    save_checkpoint(tiny_model, tmp_path / "mine" / "own.pt")
    library = open_library(replace(options, models=str(tmp_path / "mine")))
    with pytest.raises(InputError, match=r"there are: tiny, .*own"):
        library.facts([name])


def test_a_file_that_is_no_model_costs_one_line(options: ServerOptions, tmp_path: Path) -> None:
    (tmp_path / "spoilt.pt").write_bytes(b"no archive")
    library = open_library(replace(options, models=str(tmp_path)))
    with pytest.raises(InputError, match=r"spoilt\.pt is no checkpoint"):
        library.facts(["spoilt"])
    assert [one.name for one in library.facts(["tiny"])] == ["tiny"]
    with pytest.raises(InputError, match="no folder"):
        open_library(replace(options, models=str(tmp_path / "nowhere")))


def test_facts_are_the_models_own(tiny_model: RNNPB, options: ServerOptions) -> None:
    (facts,) = facts_of(tiny_model, options)
    assert (facts.name, facts.pb_dim, facts.fps) == ("tiny", 3, 20.0)
    assert facts.motions == ("wave", "bow", "rest")
    assert facts.lengths == (12, 9, 15)
    assert facts.mu.dtype == facts.sigma.dtype == np.float64
    np.testing.assert_array_equal(facts.mu, tiny_model.mu.numpy())
    np.testing.assert_array_equal(facts.sigma, tiny_model.sigma.numpy())
    assert facts.data == (None, None, None)


def test_a_model_without_names_counts_its_motions(nameless: RNNPB, options: ServerOptions) -> None:
    (facts,) = facts_of(nameless, options)
    assert facts.motions == ("motion 0", "motion 1", "motion 2")
    assert facts.lengths == (150, 150, 150)


def test_data_gives_names_lengths_and_targets(
    nameless: RNNPB, options: ServerOptions, data_folder: Path
) -> None:
    (facts,) = facts_of(nameless, replace(options, data=str(data_folder)))
    assert facts.motions == ("bow", "rest", "unknown")
    assert facts.lengths == (9, 14, 11)
    assert [len(motion) for motion in facts.data if motion is not None] == [9, 14, 11]


def test_data_becomes_the_target_of_motions_with_its_names(
    tiny_model: RNNPB, options: ServerOptions, data_folder: Path
) -> None:
    (facts,) = facts_of(tiny_model, replace(options, data=str(data_folder)))
    assert facts.motions == ("wave", "bow", "rest")
    assert [motion and motion.name for motion in facts.data] == [None, "bow", "rest"]
    assert facts.lengths == (12, 9, 15)


def test_eye_colours_come_with_the_data(
    tiny_model: RNNPB,
    options: ServerOptions,
    data_folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    options = replace(options, data=str(data_folder))
    assert facts_of(tiny_model, options)[0].eyes == ()
    track = np.zeros((9, 2, 8, 3), np.float32)
    monkeypatch.setattr("rnnpb_explorer.app.page.library.load_eyes", lambda path: {"bow": track})
    assert facts_of(tiny_model, options)[0].eyes == (None, track, None)

    def spoilt(path: str) -> None:
        raise InputError("7 is no intensity")

    monkeypatch.setattr("rnnpb_explorer.app.page.library.load_eyes", spoilt)
    (facts,) = facts_of(tiny_model, options)  # the motions are as good without
    assert facts.eyes == ()
    assert facts.data[1] is not None
    assert "7 is no intensity" in caplog.text


def test_data_of_another_number_of_motions_is_refused(
    nameless: RNNPB, options: ServerOptions, data_folder: Path
) -> None:
    (data_folder / "unknown.csv").unlink()
    with pytest.raises(InputError, match="2 motions"):
        facts_of(nameless, replace(options, data=str(data_folder)))


def test_joints_that_the_robot_lacks_are_named_in_one_line(
    tiny_model: RNNPB, options: ServerOptions
) -> None:
    facts = facts_of(tiny_model, options)
    (line,) = unmatched_joints(load_robot("pepper"), facts)
    assert "tiny" in line
    assert "pepper stands still" in line
    assert "a, b, c and 2 more" in line


# --- what it opens with ---
@pytest.mark.parametrize(("motion", "index"), [(None, 0), ("bow", 1), ("2", 2)])
def test_it_opens_with_a_motion_by_name_or_index(
    tiny_model: RNNPB, options: ServerOptions, motion: str | None, index: int
) -> None:
    facts_of(tiny_model, options)
    document = opened(replace(options, motion=motion, seed=7))
    assert document.current.latent.motion == index
    assert document.seed == 7


def test_a_motion_that_there_is_not_is_refused(tiny_model: RNNPB, options: ServerOptions) -> None:
    facts_of(tiny_model, options)
    for motion in ("jump", "3", "-1", ""):
        with pytest.raises(InputError):
            opened(replace(options, motion=motion))


def test_a_name_that_came_with_the_data_opens_as_well(
    nameless: RNNPB, options: ServerOptions, data_folder: Path
) -> None:
    options = replace(options, data=str(data_folder), motion="rest")
    facts_of(nameless, options)
    assert opened(options).current.latent.motion == 1


@pytest.mark.parametrize("frame", [0, 3, 11])
def test_it_opens_paused_at_a_frame(tiny_model: RNNPB, options: ServerOptions, frame: int) -> None:
    facts_of(tiny_model, options)
    playback = opened(replace(options, frame=frame)).playback
    assert not playback.playing
    assert playback.phase == pytest.approx(frame / 11)


@pytest.mark.parametrize("frame", [-1, 12])
def test_a_frame_that_there_is_not_is_refused(
    tiny_model: RNNPB, options: ServerOptions, frame: int
) -> None:
    facts_of(tiny_model, options)
    with pytest.raises(InputError, match="0 to 11"):
        opened(replace(options, frame=frame))


def test_it_opens_with_a_state_code(tiny_model: RNNPB, options: ServerOptions) -> None:
    facts = facts_of(tiny_model, options)
    document = opened(options)
    given = make_target(20, joints=facts[0].joints)
    document = after(facts, document, do.SelectMotion(2), do.SetMu(0, 0.625), do.SetTarget(given))
    assert opened(replace(options, state_code=encode(document))) == document
    with pytest.raises(InputError):
        opened(replace(options, state_code="nonsense"))


def test_it_opens_with_the_liveliest_motion(tiny_model: RNNPB, options: ServerOptions) -> None:
    facts = facts_of(tiny_model, options)[0]
    rated = {
        name: MotionLabel("", arousal=arousal)
        for name, arousal in zip(facts.motions, (0.2, 0.9, None), strict=True)
    }
    assert liveliest(replace(facts, labels=rated)) == 1
    assert liveliest(replace(facts, labels={})) == 0
