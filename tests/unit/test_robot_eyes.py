"""Colours of the eye LEDs from motion files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rnnpb_explorer.core.data import Dataset
from rnnpb_explorer.core.errors import InputError
from rnnpb_explorer.robot.eyes import load_eyes, load_rebl_pepper_eyes, parse_eye_colors
from rnnpb_explorer.robot.pepper import EYE_COLUMNS


def _csv(columns: tuple[str, ...], rows: list[list[float]]) -> bytes:
    lines = [",".join(columns), *(",".join(f"{value:g}" for value in row) for row in rows)]
    return "\n".join(lines).encode()


def test_colours_go_by_name() -> None:
    values = np.random.default_rng(0).integers(0, 101, (3, 48)) / 100
    order = np.random.default_rng(1).permutation(48)
    columns = ("HeadYaw", *np.array(EYE_COLUMNS)[order].tolist())
    content = _csv(columns, [[0.5, *row] for row in values[:, order].tolist()])
    colors = parse_eye_colors(content)
    assert colors is not None
    np.testing.assert_allclose(colors, values.reshape(3, 2, 8, 3), atol=1e-6)
    assert colors[1, 0, 2, 1] == pytest.approx(values[1, EYE_COLUMNS.index("R2G")])
    assert colors[2, 1, 7, 2] == pytest.approx(values[2, EYE_COLUMNS.index("L7B")])


def test_a_motion_without_leds_has_none() -> None:
    assert parse_eye_colors(_csv(("HeadYaw", "HeadPitch"), [[0, 1]])) is None


@pytest.mark.parametrize(
    ("columns", "value", "says"),
    [
        (EYE_COLUMNS[:-1], 0.0, "L7B"),
        (EYE_COLUMNS, 1.5, r"row 2, column R0R: 1.5 is no intensity"),
        (EYE_COLUMNS, -0.1, "intensity"),
        (EYE_COLUMNS, float("nan"), "not finite"),
    ],
)
def test_bad_colours_are_one_plain_line(columns: tuple[str, ...], value: float, says: str) -> None:
    with pytest.raises(InputError, match=says):
        parse_eye_colors(_csv(columns, [[value] * len(columns)]), "a.csv")


def test_rebl_pepper_has_colours_for_every_frame(dataset: Dataset, shared_dir: object) -> None:
    eyes = load_rebl_pepper_eyes(f"{shared_dir}/data/rebl-pepper")
    assert {motion.name: len(motion) for motion in dataset.motions} == {
        name: len(track) for name, track in eyes.items()
    }
    some = eyes["Happy_4"]
    assert 0 <= some.min() < some.max() <= 1
    np.testing.assert_array_equal(eyes["Happy_4_tr"][:, 0], some[:, 1])


def test_a_folder_has_the_colours_of_the_motions_that_have_any(tmp_path: Path) -> None:
    (tmp_path / "dark.csv").write_bytes(_csv(("HeadYaw",), [[0.1], [0.2]]))
    (tmp_path / "lit.csv").write_bytes(_csv(("HeadYaw", *EYE_COLUMNS), [[0.1] + [0.5] * 48] * 2))
    eyes = load_eyes(tmp_path)
    assert list(eyes) == ["lit"]
    assert eyes["lit"].shape == (2, 2, 8, 3)
    rows = [["Happy_1", "0.1"] + ["0.5"] * 48] * 2
    text = "\n".join(",".join(row) for row in [["id", "HeadYaw", *EYE_COLUMNS], *rows])
    (tmp_path / "data_raw.csv").write_text(text)
    for path in (tmp_path, tmp_path / "data_raw.csv"):
        assert set(load_eyes(path)) == {"Happy_1", "Happy_1_tr"}
