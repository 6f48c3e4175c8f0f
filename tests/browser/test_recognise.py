"""A motion comes in from a file: recognised to its end, or refused with a reason."""

from __future__ import annotations

import numpy as np
import pytest
from explorer_page import ExplorerPage, agree, differing

from rnnpb_explorer.app.page.stage import BOARD_SIZE
from rnnpb_explorer.core import Motion
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import format_motion

ROBOT = "/robot-0"
MAP, LANDSCAPE = "/boards/map", "/boards/landscape"
ITERATIONS = 30


@pytest.fixture
def recognising(explorer: ExplorerPage) -> ExplorerPage:
    explorer.tab("Recognise")
    return explorer


@pytest.fixture
def novel_motion(strong: RNNPB) -> bytes:
    """A CSV file of a motion between two learned ones, 60 frames, bent a little out of reach."""
    between = 0.5 * (strong.mu[3:4] + strong.mu[40:41])
    positions = strong.generate(between, 60)[0].numpy()
    waves = 0.05 * np.sin(np.arange(60)[:, None] / 7 + np.arange(positions.shape[1])[None])
    motion = Motion("novel", strong.info.joints, (positions + waves).astype(np.float32))
    return format_motion(motion).encode()


def test_an_uploaded_motion_is_recognised_and_its_path_is_drawn(
    recognising: ExplorerPage, novel_motion: bytes
) -> None:
    with recognising.landscape_follows():
        recognising.upload("novel.csv", novel_motion)
        recognising.text("60 frames").wait_for()
    recognising.set_value("Iterations", ITERATIONS)
    before, pose = recognising.still_pixels(), recognising.poses(ROBOT)
    with recognising.landscape_follows():
        recognising.click("Start")
        recognising.text("Recognition done").wait_for()
    recognising.screenshot("recognised")
    after = recognising.still_pixels()
    for board in (MAP, LANDSCAPE):
        region = recognising.region(board, BOARD_SIZE)
        assert differing(before[region], after[region]).mean() > 0.01, f"no path on {board}"
    assert not agree(recognising.poses(ROBOT), pose), "the robot does not show what was recognised"
    # Scrubbing back through the iterations moves the puck along the path.
    end = recognising.position(f"{MAP}-puck")
    recognising.set_value("Iteration", 1)
    recognising.wait_for(
        lambda: recognising.position(f"{MAP}-puck") != pytest.approx(end, abs=1),
        "the puck does not go back along the path",
    )


def test_a_recognition_can_be_cancelled(recognising: ExplorerPage, novel_motion: bytes) -> None:
    recognising.upload("novel.csv", novel_motion)
    recognising.text("60 frames").wait_for()
    recognising.set_value("Iterations", 300)
    recognising.set_value("Trials", 10)
    recognising.click("Start")
    recognising.click("Cancel")
    recognising.text("Recognition cancelled").wait_for()
    recognising.button("Start").wait_for()


def test_the_name_of_a_file_is_shown_as_it_is_and_does_nothing_to_the_page(
    recognising: ExplorerPage, novel_motion: bytes
) -> None:
    name = "<style>body{display:none}</style> *a*"
    recognising.upload(f"{name}.csv", novel_motion)
    recognising.text(f"Target: {name}, 60 frames").wait_for()
    recognising.upload("<b>bad.csv", b"not a motion at all")
    recognising.alert("<b>bad.csv").first.wait_for()
    recognising.tab("Explore")
    recognising.text(f"target: {name}").wait_for()


BROKEN = {  # file name: content and what the message must say
    "joint.csv": (b"HeadPitch,HeadYaw\n0,0\n0,0\n", "HipPitch"),
    "text.csv": (b"not a motion at all", "text.csv"),
    "empty.csv": (b"", "empty"),
    "binary.csv": (bytes(range(256)), "UTF-8"),
}


def test_a_broken_file_shows_its_error_and_the_session_lives_on(
    recognising: ExplorerPage, novel_motion: bytes
) -> None:
    text = novel_motion.decode().splitlines()
    text[7] = "nan" + text[7][text[7].index(",") :]
    broken = {**BROKEN, "nan.csv": ("\n".join(text).encode(), "row 8, column HeadPitch")}
    for name, (content, reason) in broken.items():
        recognising.upload(name, content)
        recognising.alert(reason).first.wait_for()
    recognising.screenshot("broken-files")
    assert recognising.button("Start").is_disabled()  # nothing was taken over
    pose = recognising.poses(ROBOT)
    recognising.tab("Explore")
    recognising.set_value("μ 1", recognising.value("μ 1") + 0.7)
    recognising.wait_for(lambda: not agree(recognising.poses(ROBOT), pose), "the session is dead")
