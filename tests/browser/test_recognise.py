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
PUBLISHED = "as published: sampling and Adam"


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
    recognising.choose("Method", PUBLISHED)
    recognising.set_value("Iterations", ITERATIONS)
    recognising.click("Start")
    recognising.text("Best: iteration").wait_for()
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
    recognising.text("Best: iteration").wait_for()
    recognising.until(lambda: told() == before, "a reload brings another screen back")
    recognising.until(lambda: agree(recognising.pose(), pose), "the robot stands otherwise")
    assert recognising.value("Iterations") == ITERATIONS


def test_a_recognition_can_be_cancelled(recognising: ExplorerPage, novel_motion: bytes) -> None:
    recognising.upload("novel.csv", novel_motion)
    recognising.text("60 frames").wait_for()
    recognising.choose("Method", PUBLISHED)
    recognising.set_value("Iterations", 300)
    recognising.set_value("Trials", 10)
    recognising.click("Start")
    recognising.click("Cancel")
    recognising.text("Cancelled after").wait_for()
    recognising.button("Start").wait_for()


def test_a_verdict_comes_in_words_and_the_belief_as_a_cloud(recognising: ExplorerPage) -> None:
    recognising.choose("Example", "halfway")
    recognising.text("Target: halfway, 120 frames").wait_for()
    recognising.text("it shrinks to a place between the two").wait_for()
    recognising.click("Start")
    recognising.text("Recognised: 100% of the observed variance explained.").wait_for()
    recognising.text("Reveal the rest to see how well it foretells").wait_for()
    recognising.tick("Reveal the rest", on=True)
    recognising.text("100% of the foretold").wait_for()
    recognising.until(
        lambda: "Belief after frame" in recognising.told("map", "belief"), "there is no cloud"
    )
    # What has been seen by the first frame says less than all of it.
    spread = []
    for frame in (0, 90):
        recognising.page.evaluate("(frame) => window.rnnpb.part.playback.seek(frame)", frame)
        at = frame - frame % 12
        recognising.until(
            lambda at=at: f"after frame {at}:" in recognising.told("map", "belief"), "another frame"
        )
        words = recognising.told("map", "belief")
        spread.append(int(words.split("spread over ")[1].split(" of ")[0]))
    assert spread[1] < 0.1 * spread[0]
    recognising.screenshot("verdict")


def test_a_motion_that_the_model_cannot_make_is_called_so(recognising: ExplorerPage) -> None:
    recognising.choose("Example", "wave")
    recognising.text("Target: wave").wait_for()
    recognising.click("Start")
    recognising.text("Beyond this model:").wait_for()


def test_half_of_the_body_is_inferred(recognising: ExplorerPage) -> None:
    recognising.choose("Example", "half_hidden")
    recognising.text("Inferred, not observed: RElbowRoll").wait_for()
    recognising.click("Start")
    recognising.text("Recognised:").wait_for()
    assert recognising.text("joints that were not observed").count() == 0
    recognising.tick("Reveal the rest", on=True)
    recognising.text("of the joints that were not observed").wait_for()
    options = recognising.page.locator("select.rb-select option").all_inner_texts()
    assert "RElbowRoll (inferred)" in options
    assert "LElbowRoll" in options


def test_a_motion_is_followed_while_it_plays(recognising: ExplorerPage) -> None:
    recognising.choose("Example", "halfway")
    recognising.text("Target: halfway").wait_for()
    recognising.choose("Method", "live: while the motion plays")
    recognising.click("Start")
    recognising.text("Recognising: frame").wait_for()
    recognising.wait_for("part.playback.clock.playing === true")
    recognising.text("All 96 frames seen").wait_for()
    assert recognising.told("map", "path").startswith("Recognition at iteration 96 of 96")


def test_a_run_is_watched_step_by_step(recognising: ExplorerPage, novel_motion: bytes) -> None:
    recognising.upload("novel.csv", novel_motion)
    recognising.text("60 frames").wait_for()
    recognising.choose("Method", PUBLISHED)
    recognising.tick("Slow enough to watch", on=True)
    recognising.click("Start")
    recognising.text("Recognising: iteration").wait_for()
    recognising.click("Pause the run")
    recognising.text("Paused at iteration").wait_for()
    line = recognising.text("Paused at iteration").inner_text()
    before = int(line.split("iteration ")[1].split(" ")[0])
    recognising.click("One step")
    recognising.text(f"Paused at iteration {before + 1} of").wait_for()
    recognising.click("Cancel")
    recognising.text(f"Cancelled after {before + 1} iterations").wait_for()


def test_what_was_found_is_taken_away(
    app: App, recognising: ExplorerPage, novel_motion: bytes
) -> None:
    recognising.upload("novel.csv", novel_motion)
    recognising.text("60 frames").wait_for()
    recognising.click("Start")
    recognising.text("Best: iteration").wait_for()
    recognising.page.get_by_text("Take it away").click()
    name, content = recognising.download("Belief path (CSV)")
    assert name == "novel_strong_belief_path.csv"
    assert content.startswith(b"trial,iteration,mu1,")
    name, content = recognising.download("Figure (PNG)")
    assert (name, content[:4]) == ("novel_strong.png", b"\x89PNG")
    recognising.click("Add to the map")
    recognising.until(lambda: recognising.told("map", "added") == "Your points: novel", "no point")
    recognising.reload(app)
    recognising.until(
        lambda: recognising.told("map", "added") == "Your points: novel", "it is lost"
    )


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
