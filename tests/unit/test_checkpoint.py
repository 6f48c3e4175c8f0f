"""Checkpoint files: what is written comes back, what is no checkpoint is refused in one line."""

from __future__ import annotations

import copy
import os
import pickle
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rnnpb_explorer.core import RNNPB, InputError, load_checkpoint, save_checkpoint
from rnnpb_explorer.core.checkpoint import read_plain, shipped_checkpoints
from rnnpb_explorer.core.checkpoint_content import to_content

from .full_disk import full_disk


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        load_checkpoint(path)
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 400
    return text


def equal(one: RNNPB, other: RNNPB) -> bool:
    states = one.state_dict(), other.state_dict()
    return (one.config, one.info) == (other.config, other.info) and all(
        torch.equal(value, states[1][name]) for name, value in states[0].items()
    )


def test_round_trip(tiny_model: RNNPB, tmp_path: Path) -> None:
    tiny_model.info.training = {"epochs": 5, "seconds": 1.5, "dataset": "mine"}
    tiny_model.info.metrics = {"reconstruction_mean": 0.25}
    save_checkpoint(tiny_model, tmp_path / "a.pt", resume={"epoch": 3})
    back = load_checkpoint(tmp_path / "a.pt")
    assert equal(tiny_model, back)
    assert not back.training  # the switch of nn.Module
    assert not any(parameter.requires_grad for parameter in back.parameters())
    assert read_plain(tmp_path / "a.pt")["resume"] == {"epoch": 3}
    assert list(tmp_path.iterdir()) == [tmp_path / "a.pt"]
    save_checkpoint(back, tmp_path / "b.pt", resume={"epoch": 3})
    assert (tmp_path / "a.pt").read_bytes() == (tmp_path / "b.pt").read_bytes()


def test_loading_leaves_the_random_numbers_alone(tiny_model: RNNPB, tmp_path: Path) -> None:
    save_checkpoint(tiny_model, tmp_path / "a.pt")
    before = torch.get_rng_state()
    load_checkpoint(tmp_path / "a.pt")
    assert torch.equal(torch.get_rng_state(), before)


def test_shipped_by_name_with_and_without_suffix() -> None:
    for name, path in shipped_checkpoints().items():
        assert equal(load_checkpoint(name), load_checkpoint(path))
        assert equal(load_checkpoint(name + ".pt"), load_checkpoint(path))


def test_an_unknown_name_lists_what_there_is(tmp_path: Path) -> None:
    for name in ("stronk", tmp_path, "a\0b"):
        with pytest.raises(InputError, match=r"no checkpoint .*; shipped with the package: ") as e:
            load_checkpoint(name)
        assert all(f"{known}.pt" in str(e.value) for known in shipped_checkpoints())


def test_published_checkpoints(published_strong: RNNPB, published_zero: RNNPB) -> None:
    for model, beta in ((published_strong, 1e-4), (published_zero, 0.0)):
        config = model.config
        assert (config.beta, config.behavior) == (beta, "stochastic")
        assert (config.pb_dim, config.hidden_size, config.num_motions) == (4, 256, 72)
        assert (model.info.motions, model.info.lengths) == ((), ())
        assert model.info.joints[0] == "HeadPitch"


def test_a_published_checkpoint_round_trips_in_our_format(
    published_zero: RNNPB, tmp_path: Path
) -> None:
    save_checkpoint(published_zero, tmp_path / "zero.pt")
    assert equal(published_zero, load_checkpoint(tmp_path / "zero.pt"))


# Files that are no checkpoint


def test_no_checkpoint_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.pt"
    for content in (b"", b"not a checkpoint", b"PK\x03\x04 almost", os.urandom(5000)):
        path.write_bytes(content)
        assert refusal(path) == f"{path} is no checkpoint, or a truncated one"
    torch.save([1, 2], path)
    assert refusal(path) == f"{path} is no RNNPB checkpoint"
    torch.save({"weights": torch.zeros(3)}, path)
    assert "neither ours nor a published model.tar" in refusal(path)
    torch.save({"a": 1}, path, _use_new_zipfile_serialization=False)  # the format before 2020
    assert "is no checkpoint" in refusal(path)


def test_truncated(tiny_model: RNNPB, tmp_path: Path) -> None:
    path = tmp_path / "a.pt"
    save_checkpoint(tiny_model, path)
    content = path.read_bytes()
    for share in (0.1, 0.5, 0.9, 0.999):
        path.write_bytes(content[: int(share * len(content))])
        assert "is no checkpoint" in refusal(path)


class Malicious:
    """Pickles to a call that makes a file."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return (os.system, (f"touch '{self.mark}'",))


@pytest.mark.parametrize("where", ["inside", "alone", "published"])
def test_code_in_a_file_never_runs(tiny_model: RNNPB, tmp_path: Path, where: str) -> None:
    mark, path = tmp_path / "it-ran", tmp_path / "a.pt"
    evil = Malicious(mark)
    contents = {
        "inside": to_content(tiny_model) | {"resume": evil},
        "alone": evil,
        "published": {"params": {}, "model_state_dict": {}, "loss": evil},
    }
    torch.save(contents[where], path)
    assert "cannot be read safely" in refusal(path) or "read safely" in refusal(path)
    assert not mark.exists()
    torch.load(path, weights_only=False)  # it does run where nobody looks
    assert mark.exists()


def test_code_in_a_plain_pickle_never_runs(tmp_path: Path) -> None:
    mark, path = tmp_path / "it-ran", tmp_path / "a.pt"
    path.write_bytes(pickle.dumps(Malicious(mark)))
    assert "is no checkpoint" in refusal(path)
    assert not mark.exists()


def test_an_archive_that_unpacks_to_more_than_fits(tmp_path: Path) -> None:
    path = tmp_path / "a.pt"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for part in range(25):
            archive.writestr(f"a/data/{part}", bytes(10_000_000))
    assert path.stat().st_size < 1_000_000
    assert "more than 200 MB" in refusal(path)


# Files of our format with something wrong in them


def with_config(**changes: Any) -> Callable[[dict[str, Any]], None]:
    return lambda content: content["config"].update(changes)


def with_info(**changes: Any) -> Callable[[dict[str, Any]], None]:
    return lambda content: content["info"].update(changes)


def with_state(**changes: Any) -> Callable[[dict[str, Any]], None]:
    return lambda content: content["state"].update(changes)


def without(*keys: str) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        for key in keys[:-1]:
            content = content[key]
        del content[keys[-1]]

    return change


NAN_MU = torch.full((3, 3), float("nan"))
WRONG = {
    "version": (lambda c: c.update(version=7), "format version 7, this program reads 1"),
    "no version": (without("version"), "format version None"),
    "two versions": (lambda c: c.update(version=torch.ones(2)), "format version a Tensor"),
    "config missing": (without("config"), "config is None, expected a table"),
    "config a list": (lambda c: c.update(config=[1]), "config is a list, expected a table"),
    "no hidden_size": (without("config", "hidden_size"), "hidden_size is None"),
    "huge": (with_config(hidden_size=10**9), "hidden_size is 1000000000, expected a whole number"),
    "many": (with_config(num_motions=10**12), "num_motions is 1000000000000"),
    "negative": (with_config(pb_dim=-1), "pb_dim is -1, expected a whole number 1 to 128"),
    "text size": (with_config(num_joints="5"), "num_joints is '5', expected a whole number"),
    "real size": (with_config(num_joints=5.0), "num_joints is 5.0, expected a whole number"),
    "truth size": (with_config(num_joints=True), "num_joints is True"),
    "behavior": (with_config(behavior="wild"), "behavior is 'wild'"),
    "long text": (with_config(behavior="x" * 10**6), "behavior is "),
    "beta": (with_config(beta=-1.0), "beta is -1.0"),
    "beta nan": (with_config(beta=float("nan")), "beta is nan"),
    "beta missing": (with_config(beta=None), "beta is None, expected a number"),
    "unknown entry": (with_config(layers=2), "config has entries this program does not know"),
    "shapes": (with_config(pb_dim=4), "mu has shape (3, 3), its config asks for shape (3, 4)"),
    "other shape": (
        with_state(weight_hidden=torch.zeros(64, 15)),
        "weight_hidden has shape (64, 15), its config asks for shape (64, 16)",
    ),
    "no tensor": (without("state", "bias"), "it has no tensor bias"),
    "a number": (with_state(bias=1.0), "it has no tensor bias"),
    "whole numbers": (with_state(mu=torch.zeros(3, 3, dtype=torch.int64)), "mu is no ordinary"),
    "complex": (with_state(mu=torch.zeros(3, 3, dtype=torch.complex64)), "mu is no ordinary"),
    "sparse": (with_state(mu=torch.eye(3).to_sparse()), "mu is no ordinary tensor"),
    "nan": (with_state(mu=NAN_MU), "mu holds NaN or infinity"),
    "inf": (with_state(bias=torch.full((64,), torch.inf)), "bias holds NaN or infinity"),
    "far": (with_state(mu=torch.full((3, 3), 1e30)), "mu holds numbers beyond 1e+06"),
    "sigma": (with_state(log_var=torch.full((3, 3), 1e4)), "whose sigma is not finite"),
    "repeated": (
        with_state(weight_hidden=torch.zeros(1).expand(64, 16)),
        "weight_hidden has fewer numbers than its shape (64, 16) says",
    ),
    "info missing": (without("info"), "info is None, expected a table"),
    "joints": (with_info(joints=("a", "b")), "it names 2 joints for 5 outputs"),
    "joints no list": (with_info(joints="abcde"), "joints is 'abcde', expected a list"),
    "joint no text": (with_info(joints=(1, 2, 3, 4, 5)), "one of its joints is 1, expected text"),
    "twins": (with_info(joints=tuple("aabcd")), "two of its joints have the same name"),
    "unseen": (with_info(joints=("a\n", *"bcde")), "characters that cannot be shown"),
    "half a letter": (with_info(joints=("\ud800", *"bcde")), "cannot be shown"),
    "motions": (with_info(motions=("a", "b")), "it has 2 motions for 3 PBs"),
    "lengths": (with_info(lengths=(5, 6)), "it has 2 lengths for 3 PBs"),
    "no length": (with_info(lengths=(5, 6, 0)), "length of a motion is 0"),
    "endless": (with_info(lengths=(5, 6, 10**9)), "length of a motion is 1000000000"),
    "fps": (with_info(fps=0.0), "fps is 0.0"),
    "fps inf": (with_info(fps=float("inf")), "fps is inf"),
    "labels": (with_info(labels=["wave"]), "labels is a list, expected a table"),
    "label": (with_info(labels={"wave": 3}), "label is 3, expected a table"),
    "class": (with_info(labels={"wave": {"behavior_class": 1}}), "behavior_class is 1"),
    "metrics": (with_info(metrics={"error": "low"}), "metric 'error' is 'low', expected a number"),
    "metric nan": (with_info(metrics={"error": float("nan")}), "metric 'error' is nan"),
    "metric": (with_info(metrics={"error": 10**400}), "metric 'error' is a huge number"),
    "training": (with_info(training={"a": [1]}), "training record has no plain value for 'a'"),
    "attribution": (with_info(attribution=3), "attribution is 3, expected text"),
    "other info": (with_info(robot="x"), "info has entries this program does not know: 'robot'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_does_not_fit_is_refused(tiny_model: RNNPB, tmp_path: Path, case: str) -> None:
    change, words = WRONG[case]
    content = copy.deepcopy(to_content(tiny_model))
    change(content)
    path = tmp_path / "a.pt"
    torch.save(content, path)
    text = refusal(path)
    assert text.startswith(f"cannot use {path}: ")
    assert words in text


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c["params"]["model"].update(hidden_size=10**9), "hidden_size is 1000000000"),
        (lambda c: c["params"]["model"].update(num_layers=2), "2 LSTM layers"),
        (lambda c: c["params"]["model"].update(num_layers=torch.ones(2)), "a Tensor LSTM layers"),
        (lambda c: c["params"].pop("model"), "params: model is None, expected a table"),
        (lambda c: c["params"]["model"].update(pb_size=5), "mu_pb has shape (72, 4), its config"),
        (lambda c: c["model_state_dict"].pop("linear.bias"), "it has no tensor linear.bias"),
        (lambda c: c["model_state_dict"]["mu_pb"].fill_(torch.nan), "mu_pb holds NaN"),
    ],
)
def test_a_damaged_published_checkpoint(
    shared_dir: Path, tmp_path: Path, change: Callable[[dict[str, Any]], object], words: str
) -> None:
    published = shared_dir / "reference" / "zero_prior" / "model.tar"
    content = read_plain(published)
    with torch.no_grad():
        change(content)
    torch.save({key: content[key] for key in ("params", "model_state_dict")}, tmp_path / "m.tar")
    assert words in refusal(tmp_path / "m.tar")


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_flipped_bytes_never_raise_anything_else(
    tiny_model: RNNPB, tmp_path: Path, data: st.DataObject
) -> None:
    """Loaded or refused; the archive's check sums and the pickle are both in reach of the flips."""
    path = tmp_path / "a.pt"
    save_checkpoint(tiny_model, path)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 5))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    try:
        load_checkpoint(path)
    except InputError:
        return


# Writing


def test_a_failed_write_leaves_the_old_file(tiny_model: RNNPB, tmp_path: Path) -> None:
    path = tmp_path / "a.pt"
    save_checkpoint(tiny_model, path)
    before = path.read_bytes()
    tiny_model.info = replace(tiny_model.info, attribution="new")
    with full_disk(1000), pytest.raises(InputError, match=r"cannot write .*a\.pt"):
        save_checkpoint(tiny_model, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_where_nothing_can_be_written(tiny_model: RNNPB, tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none" / "a.pt", Path("/dev/null")):
        with pytest.raises(InputError, match="cannot write"):
            save_checkpoint(tiny_model, path)
    assert Path("/dev/null").is_char_device()


def test_a_link_stays_a_link(tiny_model: RNNPB, tmp_path: Path) -> None:
    link = tmp_path / "link.pt"
    link.symlink_to(tmp_path / "real.pt")
    save_checkpoint(tiny_model, link)
    assert link.is_symlink()
    assert equal(load_checkpoint(tmp_path / "real.pt"), tiny_model)
