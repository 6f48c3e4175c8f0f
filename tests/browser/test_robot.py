"""Pepper on the screen: it moves, uncertain and within limits; and what leaves for a real one."""

from __future__ import annotations

import re

import pytest
from explorer_page import ExplorerPage, agree
from playwright.sync_api import expect


def test_a_frame_is_drawn_as_it_was_and_another_one_otherwise(explorer: ExplorerPage) -> None:
    pictures = []
    for key in ("Home", "End", "Home"):
        explorer.page.get_by_role("slider", name="Frame").press(key)
        pictures.append(explorer.canvas())
    assert pictures[0] != pictures[1]
    assert pictures[0] == pictures[2]


def test_the_uncertainty_is_a_fan_of_ghosts_and_a_band(explorer: ExplorerPage) -> None:
    for dim in (1, 2, 3, 4):
        explorer.set_value(f"σ {dim}", 0.9)
    pose = explorer.pose()
    explorer.tab("View")
    explorer.tick("Uncertainty", True)
    explorer.wait_for("part.robots.robots[0].copies.length === 8")
    explorer.wait_for("part.timebar.band !== null && part.robots.unsettled === 0")
    ghosts = explorer.part(
        "part.robots.robots[0].copies.map(({ nodes }) => String(nodes[4].quaternion.toArray()))"
    )
    assert len(set(ghosts)) == 8
    assert agree(explorer.pose(), pose)
    explorer.screenshot("uncertainty")
    explorer.tick("Uncertainty", False)
    explorer.wait_for("part.robots.robots[0].copies.length === 0")
    explorer.wait_for("part.timebar.band === null")


def test_the_limited_motion_moves_beside_the_raw_one(explorer: ExplorerPage) -> None:
    explorer.text("within the robot's limits").wait_for()
    for dim in (1, 2, 3, 4):  # far from everything learnt
        explorer.set_value(f"μ {dim}", 9 * (-1) ** dim)
    explorer.text("far beyond the limits").wait_for()
    assert explorer.told("map", "extrapolation").startswith("Extrapolating: ")
    explorer.tab("Robot")
    explorer.page.get_by_text(re.compile(r": .* rad.*, frames? \d")).first.wait_for()
    explorer.tick("Side by side", True)
    explorer.wait_for("part.robots.robots[1]?.copies[0]?.nodes.every(Boolean)")
    explorer.wait_for("part.robots.robots[1].motion && part.robots.unsettled === 0")
    assert not agree(explorer.pose(1), explorer.pose()), "the limited motion is the raw one"
    explorer.until(
        lambda: explorer.names() == ["strong, raw", "strong, limited"], "the robots have no names"
    )
    explorer.screenshot("side-by-side")
    explorer.tick("Side by side", False)
    explorer.wait_for("part.robots.robots.length === 1")
    explorer.until(lambda: explorer.names() == [], "a lone robot keeps its name")


@pytest.mark.parametrize(
    ("label", "suffix"), [("CSV", ".csv"), ("JSON", ".json"), ("NAOqi script", ".py")]
)
def test_what_is_exported_can_be_uploaded(explorer: ExplorerPage, label: str, suffix: str) -> None:
    explorer.tab("Robot")
    if suffix != ".csv":  # which it begins with
        explorer.choose("Format", label)
    name, content = explorer.download("Export the motion")
    assert name == f"Alienated_1_strong{suffix}"
    explorer.text(f"{name}: 307 frames").wait_for()
    explorer.tab("Recognise")
    explorer.upload(name, content)
    explorer.text("307 frames at 25 Hz").wait_for()


def test_space_starts_and_stops_it_once_a_press(explorer: ExplorerPage) -> None:
    start = explorer.pose()
    explorer.click("Play")
    explorer.until(lambda: not agree(explorer.pose(), start), "the robot does not play")
    # The button has the focus now and reacts to Space, too: one press must still toggle once.
    for shown in ("Play", "Pause", "Play"):
        explorer.page.keyboard.press("Space")
        expect(explorer.button(shown)).to_be_visible()
    still = explorer.canvas()
    assert explorer.canvas() == still
