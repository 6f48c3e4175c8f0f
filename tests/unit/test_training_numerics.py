"""Training on tiny data: the published loss, determinism, resuming bit for bit, learning."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from rnnpb_explorer.core.checkpoint import load_checkpoint, read_plain, save_checkpoint
from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.core.model import RNNPB, ModelConfig, kl_divergence
from rnnpb_explorer.core.motion import Motion
from rnnpb_explorer.core.muon import Muon, orthogonal
from rnnpb_explorer.core.training import Trainer, TrainingConfig

SMALL = ModelConfig(pb_dim=2, hidden_size=12, beta=1e-3)
RECIPE = TrainingConfig(epochs=6, warm_up_epochs=2, seed=4)
HELD_TO_AVX2 = {"ATEN_CPU_CAPABILITY": "avx2", "ONEDNN_MAX_CPU_ISA": "AVX2"}


@pytest.fixture
def waves() -> Dataset:
    """Five motions of three joints, 9 to 25 frames, in two buckets or more."""
    joints = ("a", "b", "c")
    motions = []
    for number, frames in enumerate((9, 25, 10, 24, 16)):
        time = np.arange(frames)[:, None] / 8
        positions = np.sin(time * (1 + number / 3) + np.arange(3)) * 0.5
        motions.append(Motion(f"wave {number}", joints, positions.astype(np.float32)))
    return Dataset(tuple(motions), {})


@pytest.fixture
def restore_threads() -> Iterator[None]:
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


def weights(model: RNNPB) -> dict[str, torch.Tensor]:
    return {name: value.clone() for name, value in model.state_dict().items()}


def assert_same_bits(first: RNNPB, second: RNNPB) -> None:
    for name, value in weights(first).items():
        assert torch.equal(value, second.state_dict()[name]), name


@pytest.mark.parametrize("behavior", ["stochastic", "deterministic"])
def test_an_epoch_follows_the_published_loss(waves: Dataset, behavior: str) -> None:
    """Squared error summed over joints, mean over all frames; KL summed over everything."""
    beta = 1e-3 if behavior == "stochastic" else None
    config = replace(SMALL, behavior=behavior, beta=beta)  # type: ignore[arg-type]
    trainer = Trainer(waves, config, replace(RECIPE, max_gradient_norm=1e9))
    with torch.no_grad():  # from mu = 0 the PBs' gradients would be very small
        trainer.model.mu.normal_(generator=torch.Generator().manual_seed(0))
    model = RNNPB(trainer.model.config, trainer.model.info)
    model.load_state_dict(weights(trainer.model))

    noise = torch.randn(model.mu.shape, generator=torch.Generator().manual_seed(RECIPE.seed))
    pbs, kl = model.mu, torch.zeros(())
    if behavior == "stochastic":
        pbs = model.mu + model.sigma * noise
        kl = kl_divergence(model.mu, model.log_var)
    squared = sum(
        (model.generate_stepwise(pb, len(motion)) - torch.as_tensor(motion.positions))
        .square()
        .sum()
        for pb, motion in zip(pbs, waves.motions, strict=True)
    )
    frames = sum(len(motion) for motion in waves.motions)
    loss = squared / frames + (beta or 0.0) * kl
    loss.backward()

    progress = next(trainer.run())
    assert progress.loss == pytest.approx(loss.item(), rel=1e-5)
    assert progress.error == pytest.approx(squared.item() / frames / 3, rel=1e-5)
    assert progress.kl == pytest.approx(kl.item())
    for (name, trained), plain in zip(
        trainer.model.named_parameters(), model.parameters(), strict=True
    ):
        if trained.grad is None:
            assert plain.grad is None, name
        else:
            torch.testing.assert_close(trained.grad, plain.grad, rtol=1e-4, atol=1e-7, msg=name)


def test_the_recurrent_weights_of_each_gate_step_by_an_orthogonal_matrix(waves: Dataset) -> None:
    """Muon: every direction of a gate's weights moves by about the rate, however small its share
    of the gradient; the four gates of the one matrix do not share that length between them."""
    trainer = Trainer(waves, SMALL, RECIPE)
    before = trainer.model.weight_hidden.detach().clone()
    next(trainer.run())
    rate = RECIPE.recurrent_rate / RECIPE.warm_up_epochs  # of the first epoch
    steps = (before - trainer.model.weight_hidden.detach()).chunk(4)
    for name, step in zip("ifgo", steps, strict=True):
        largest = torch.linalg.svdvals(step)[: SMALL.hidden_size // 2] / rate
        assert largest.min() > 0.6, name
        assert largest.max() < 1.3, name


def test_muon_is_that_of_torch_but_for_bfloat16() -> None:
    """Three steps on a stack of two matrices against torch.optim.Muon on each of them."""
    random = torch.Generator().manual_seed(0)
    start = torch.randn((32, 16), generator=random)
    stack = torch.nn.Parameter(start.clone())
    pair = [torch.nn.Parameter(half) for half in start.clone().chunk(2)]
    ours = Muon([stack], 0.05, 0.9, matrices=2)
    theirs = torch.optim.Muon(pair, 0.05, 0.0, 0.9)
    for _ in range(3):
        stack.grad = torch.randn((32, 16), generator=random)
        for half, gradient in zip(pair, stack.grad.chunk(2), strict=True):
            half.grad = gradient
        ours.step()
        theirs.step()
    moved = stack.detach() - start
    difference = moved - (torch.cat(pair).detach() - start)
    assert torch.linalg.vector_norm(moved) > 0.3
    assert torch.linalg.vector_norm(difference) < 0.02 * torch.linalg.vector_norm(moved)


def test_a_gradient_of_zeros_makes_no_step() -> None:
    assert not orthogonal(torch.zeros(3, 3)).any()


class _Dtypes(TorchDispatchMode):
    def __init__(self) -> None:
        super().__init__()
        self.seen: set[torch.dtype] = set()

    def __torch_dispatch__(
        self, function: Any, types: Any, args: Any = (), kwargs: Any = None
    ) -> Any:
        out = function(*args, **(kwargs or {}))
        self.seen |= {leaf.dtype for leaf in tree_leaves(out) if isinstance(leaf, torch.Tensor)}
        return out


def test_nothing_is_in_bfloat16(waves: Dataset, restore_threads: None) -> None:
    """Which a processor without units for it emulates, 30 times as slow as float32."""
    torch.set_num_threads(1)  # one sees what its own thread does
    trainer = Trainer(waves, SMALL, RECIPE)
    with _Dtypes() as dtypes:
        next(trainer.run())
    assert torch.float32 in dtypes.seen
    assert not dtypes.seen & {torch.bfloat16, torch.float16}


def test_the_number_of_cores_changes_no_bit(waves: Dataset, restore_threads: None) -> None:
    trained = []
    for cores in (1, 3):
        torch.set_num_threads(cores)
        trained.append(Trainer(waves, replace(SMALL, hidden_size=64), replace(RECIPE, samples=40)))
        losses = [progress.loss for progress in trained[-1].run()]
        assert len(losses) == 6
        assert torch.get_num_threads() == cores
    assert_same_bits(*(trainer.model for trainer in trained))


def test_trains_so_on_a_processor_without_bfloat16(tmp_path: Path) -> None:
    """Every test of this file, and the command's, in a process that is held to AVX2."""
    if HELD_TO_AVX2.items() <= os.environ.items():
        assert torch.backends.cpu.get_cpu_capability() in ("AVX2", "DEFAULT")
        return
    files = [__file__, str(Path(__file__).with_name("test_cli_train.py"))]
    those = "not refuses and not bar and not evaluate"
    outcome = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-k",
            those,
            "--basetemp",
            tmp_path / "held",
            *files,
        ],
        # What CI requires of a run is required of the outer one.
        env={k: v for k, v in os.environ.items() if not k.startswith("RNNPB_")} | HELD_TO_AVX2,
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert outcome.returncode == 0, outcome.stdout
    assert " passed" in outcome.stdout


def test_samples_are_averaged_in_mirrored_pairs(waves: Dataset) -> None:
    trainer = Trainer(waves, SMALL, replace(RECIPE, samples=3))
    with torch.no_grad():
        trainer.model.mu.normal_(generator=torch.Generator().manual_seed(0))
    model = RNNPB(trainer.model.config, trainer.model.info)
    model.load_state_dict(weights(trainer.model))
    random = torch.Generator().manual_seed(RECIPE.seed)
    first, second = torch.randn((2, *model.mu.shape), generator=random)
    errors = [
        (model.generate_stepwise(pb, len(motion)) - torch.as_tensor(motion.positions))
        .square()
        .sum()
        for noise in (first, second, -first)
        for pb, motion in zip(model.mu + model.sigma * noise, waves.motions, strict=True)
    ]
    values = 3 * 3 * sum(len(motion) for motion in waves.motions)
    progress = next(trainer.run())
    assert progress.error == pytest.approx(sum(errors).item() / values, rel=1e-5)


@pytest.mark.filterwarnings("ignore:Detected call of `lr_scheduler.step")  # the first epoch is one
def test_an_epoch_without_finite_gradient_changes_nothing(waves: Dataset) -> None:
    far = [Motion(m.name, m.joints, m.positions * np.float32(1e25)) for m in waves.motions]
    trainer = Trainer(Dataset(tuple(far), {}), SMALL, RECIPE)
    before = weights(trainer.model)
    progress = next(trainer.run())
    assert progress.epoch == 1
    assert not np.isfinite(progress.loss)
    for name, value in before.items():
        assert torch.equal(value, trainer.model.state_dict()[name]), name


def test_the_seed_decides_everything(waves: Dataset) -> None:
    def trained(seed: int) -> Trainer:
        trainer = Trainer(waves, SMALL, replace(RECIPE, seed=seed))
        torch.rand(5)  # the global generator plays no part
        list(trainer.run())
        return trainer

    assert_same_bits(trained(4).model, trained(4).model)
    assert not torch.equal(trained(4).model.mu, trained(5).model.mu)


def test_making_a_trainer_leaves_the_global_generator_alone(waves: Dataset) -> None:
    torch.manual_seed(1)
    expected = torch.rand(3)
    torch.manual_seed(1)
    Trainer(waves, SMALL, RECIPE)
    assert torch.equal(torch.rand(3), expected)


def test_resumes_bit_for_bit_through_a_file(waves: Dataset, tmp_path: Path) -> None:
    straight = Trainer(waves, SMALL, RECIPE)
    losses = [progress.loss for progress in straight.run()]

    interrupted = Trainer(waves, SMALL, RECIPE)
    for progress in interrupted.run():
        if progress.epoch == 2:
            break
    path = tmp_path / "half.pt"
    save_checkpoint(interrupted.model, path, resume=interrupted.state())

    resumed = Trainer(waves, SMALL, RECIPE)
    resumed.restore(load_checkpoint(path), read_plain(path)["resume"])
    rest = list(resumed.run())
    assert [progress.epoch for progress in rest] == [3, 4, 5, 6]
    assert [progress.loss for progress in rest] == losses[2:]
    assert_same_bits(resumed.model, straight.model)


def test_resumes_bit_for_bit_where_the_memory_of_adam_changes(waves: Dataset) -> None:
    recipe = replace(RECIPE, late_beta2=0.999)
    straight = Trainer(waves, SMALL, recipe)
    losses = [progress.loss for progress in straight.run()]
    unchanged = [progress.loss for progress in Trainer(waves, SMALL, RECIPE).run()]
    half = RECIPE.epochs // 2
    assert losses[: half + 1] == unchanged[: half + 1]  # an epoch's loss is that before its step
    assert losses[half + 1] != unchanged[half + 1]
    interrupted = Trainer(waves, SMALL, recipe)
    for progress in interrupted.run():
        if progress.epoch == half:
            break
    resumed = Trainer(waves, SMALL, recipe)
    resumed.restore(interrupted.model, interrupted.state())
    assert [progress.loss for progress in resumed.run()] == losses[half:]


def test_a_run_names_every_kind_of_processor_it_ran_on(
    waves: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another kind rounds differently: the run goes on, and the record says why its bits differ."""
    kinds = iter(["AVX2", "AVX512", "AVX512", "AVX2", "AVX2"])
    monkeypatch.setattr(torch.backends.cpu, "get_cpu_capability", lambda: next(kinds))
    trainer = Trainer(waves, SMALL, RECIPE)
    next(trainer.run())
    assert trainer.model.info.training["processors"] == "AVX2"
    for expected in ("AVX2, AVX512", "AVX2, AVX512"):
        resumed = Trainer(waves, SMALL, RECIPE)
        resumed.restore(trainer.model, trainer.state())
        assert resumed.model.info.training["processors"] == expected
        trainer = resumed


def test_does_not_resume_another_run(waves: Dataset) -> None:
    trainer = Trainer(waves, SMALL, RECIPE)
    next(trainer.run())
    state = trainer.state()
    with pytest.raises(InputError, match="another recipe"):
        Trainer(waves, SMALL, replace(RECIPE, seed=9)).restore(trainer.model, state)
    with pytest.raises(InputError, match="another model or other data"):
        Trainer(waves, replace(SMALL, hidden_size=13), RECIPE).restore(trainer.model, state)
    with pytest.raises(InputError, match="begun by a version"):
        Trainer(waves, SMALL, RECIPE).restore(trainer.model, state | {"algorithm": 1})


@pytest.mark.parametrize("behavior", ["stochastic", "deterministic"])
def test_learns(waves: Dataset, behavior: str) -> None:
    beta = 1e-4 if behavior == "stochastic" else None
    config = replace(SMALL, behavior=behavior, beta=beta)  # type: ignore[arg-type]
    recipe = replace(RECIPE, epochs=250, learning_rate=1e-2, warm_up_epochs=10)
    errors = [progress.error for progress in Trainer(waves, config, recipe).run()]
    assert len(errors) == 250
    assert np.mean(errors[-10:]) < 0.3 * np.mean(errors[:10])
