"""A motion comes in from a file: recognised to its end, or refused with a reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from explorer_page import ExplorerPage, agree

from rnnpb_explorer.app.page.server import App
from rnnpb_explorer.core import Motion
from rnnpb_explorer.core.model import RNNPB
from rnnpb_explorer.core.motion import format_motion

FIELD = Path(__file__).parents[1] / "field" / "motions"
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


def test_an_uploaded_motion_is_recognised_and_a_reload_brings_it_back(
    app: App, recognising: ExplorerPage, novel_motion: bytes
) -> None:
    pose = recognising.pose()
    with recognising.landscape_follows():
        recognising.upload("novel.csv", novel_motion)
        recognising.text("60 frames").wait_for()
    assert recognising.told("landscape", "target") == "Compared with novel"
    recognising.set_value("Iterations", ITERATIONS)
    recognising.click("Start")
    recognising.text("Recognition done").wait_for()
    whole = f"Recognition at iteration {ITERATIONS} of {ITERATIONS}:"
    assert not agree(recognising.pose(), pose), "the robot does not show what was recognised"
    # Scrubbing through the iterations moves the puck along the path.
    recognising.set_value("Iteration", ITERATIONS)
    recognising.until(lambda: recognising.told("map", "path").startswith(whole), "no whole path")
    assert recognising.told("landscape", "path").startswith(whole)
    end = recognising.puck("map")
    recognising.set_value("Iteration", 1)
    recognising.until(
        lambda: recognising.puck("map") != pytest.approx(end, abs=1),
        "the puck does not go back along the path",
    )
    recognising.screenshot("recognised")

    def told() -> list[str]:
        boards = [("map", "puck"), ("map", "path"), ("landscape", "path"), ("landscape", "target")]
        return [recognising.told(*one) for one in boards]

    before, pose = told(), recognising.pose()
    recognising.reload(app)
    recognising.tab("Recognise")
    recognising.text("Recognition done").wait_for()
    recognising.until(lambda: told() == before, "a reload brings another screen back")
    recognising.until(lambda: agree(recognising.pose(), pose), "the robot stands otherwise")
    assert recognising.value("Iterations") == ITERATIONS


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
    recognising.alert("<b>bad.csv").wait_for()
    assert recognising.told("landscape", "target") == f"Compared with {name}"


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
        recognising.alert(reason).wait_for()
    recognising.screenshot("broken-files")
    assert recognising.button("Start").is_disabled()  # nothing was taken over
    pose = recognising.pose()
    recognising.tab("Explore")
    recognising.set_value("μ 1", recognising.value("μ 1") + 0.7)
    recognising.until(lambda: not agree(recognising.pose(), pose), "the session is dead")


TARGET_SEEN = "part.robots.robots[1]?.copies[0]?.root.visible"


def test_the_target_stands_beside_and_goes_where_nobody_has_seen_it(
    recognising: ExplorerPage, novel_motion: bytes
) -> None:
    recognising.upload("novel.csv", novel_motion)
    recognising.wait_for(f"{TARGET_SEEN} === true")
    assert recognising.names() == ["strong", "target"]
    seek = "(frame) => window.rnnpb.part.playback.seek(frame)"
    for frame, seen in ((55, False), (20, True), (55, False)):  # 48 of 60 frames are observed
        recognising.page.evaluate(seek, frame)
        recognising.wait_for(f"{TARGET_SEEN} === {str(seen).lower()}")
    recognising.tick("Reveal the rest", on=True)
    recognising.wait_for(f"{TARGET_SEEN} === true")
    recognising.tick("Show the target", on=False)
    recognising.wait_for("part.robots.robots.length === 1")


def test_a_file_of_several_motions_offers_them(recognising: ExplorerPage) -> None:
    name = "two-motions-id-column.csv"
    recognising.upload(name, (FIELD / name).read_bytes())
    recognising.text("Target: A, 30 frames").wait_for()
    recognising.alert("2 motions in it").wait_for()
    recognising.choose("Motion in it", "B")
    recognising.text("Target: B, 30 frames").wait_for()
