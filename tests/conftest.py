"""Fixtures for every test: the data beside the repository, the shipped model, a tiny one."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from shared_files import shared

from rnnpb_explorer.core.checkpoint import load_checkpoint, shipped_checkpoints
from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.files import CACHE_VARIABLE
from rnnpb_explorer.core.model import RNNPB, ModelConfig, ModelInfo
from rnnpb_explorer.core.motion import MotionLabel
from rnnpb_explorer.robot.data import load_dataset

BROWSER_REQUIRED = os.environ.get("RNNPB_REQUIRE_BROWSER") == "1"
browser_outcomes: Counter[str] = Counter()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if "browser" in report.keywords and (report.when == "call" or report.outcome != "passed"):
        browser_outcomes[report.outcome] += 1


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Where a browser is required, a run that skipped browser tests or had none has failed."""
    if not BROWSER_REQUIRED or session.config.option.collectonly:
        return
    if browser_outcomes["skipped"] or not browser_outcomes["passed"]:
        session.exitstatus = session.exitstatus or pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if BROWSER_REQUIRED:
        counts = ", ".join(f"{count} {what}" for what, count in browser_outcomes.items())
        terminalreporter.write_line(f"browser tests (required): {counts or 'none'}")


@pytest.fixture(scope="session")
def shared_dir() -> Path:
    """The folder beside the repository with REBL-Pepper and the published checkpoints."""
    return shared()


@pytest.fixture(scope="session")
def published_pepper() -> Path:
    """The URDF file of Pepper's published description."""
    return shared("robots", "pepper_description", "urdf", "pepper.urdf")


@pytest.fixture(autouse=True, scope="session")
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test leaves anything in the user's cache, or finds something there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(CACHE_VARIABLE, str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def dataset() -> Dataset:
    """The 72 motions of REBL-Pepper, mirrored ones included."""
    return load_dataset(shared("data", "rebl-pepper", "data_raw.csv"))


@pytest.fixture(scope="session")
def strong() -> RNNPB:
    """The shipped checkpoint that the app starts with."""
    if "strong" not in shipped_checkpoints():
        pytest.skip("checkpoints/strong.pt is not there")
    return load_checkpoint("strong")


@pytest.fixture(scope="session")
def published_strong() -> RNNPB:
    """The authors' checkpoint `strong_prior` (beta = 1e-4)."""
    return load_checkpoint(shared("reference", "strong_prior", "model.tar"))


@pytest.fixture(scope="session")
def published_zero() -> RNNPB:
    """The authors' checkpoint `zero_prior` (beta = 0)."""
    return load_checkpoint(shared("reference", "zero_prior", "model.tar"))


@pytest.fixture
def tiny_model() -> RNNPB:
    """Random weights: 3 motions, D_PB = 3, 5 joints, 16 hidden units; nothing of Pepper in it."""
    names = ("wave", "bow", "rest")
    info = ModelInfo(
        joints=("a", "b", "c", "d", "e"),
        fps=20.0,
        motions=names,
        lengths=(12, 9, 15),
        labels={name: MotionLabel(name) for name in names},
    )
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        model = RNNPB(
            ModelConfig(num_joints=5, pb_dim=3, hidden_size=16, num_motions=len(names)), info
        )
        torch.nn.init.normal_(model.mu)
        torch.nn.init.normal_(model.log_var, mean=-2.0, std=0.5)
    return model.eval().requires_grad_(False)
