"""Two tabs of a browser: neither sees what the other does, and each comes back as it was."""

from __future__ import annotations

import pytest
from explorer_page import ExplorerPage, agree

from rnnpb_explorer.app.page.server import App


def test_two_tabs_are_two_sessions(app: App, explorer: ExplorerPage) -> None:
    other = explorer.another()
    pose, mu, puck = other.pose(), other.mu(), other.puck("map")

    start = explorer.puck("map")
    with explorer.landscape_follows():
        explorer.drag(start, (start[0] - 40, start[1] + 15))
    assert not agree(explorer.pose(), pose)
    # Whatever the first one did would have arrived by the time this answer has.
    other.tab("View")
    other.choose("Colour", "valence")
    other.until(lambda: other.told("map", "colouring") == "Coloured by valence", "no colours")
    assert agree(other.pose(), pose)
    assert other.mu() == mu
    assert other.puck("map") == puck
    assert explorer.told("map", "colouring") == "Coloured by class"

    there = explorer.told("map", "puck")
    explorer.reload(app)
    explorer.wait_for("part.map.state !== null")
    assert explorer.told("map", "puck") == there
    assert explorer.value("μ 2") != pytest.approx(mu[1], abs=0.01)

    explorer.page.goto("about:blank")  # one leaves; the other goes on
    other.tab("Explore")
    other.set_value("μ 2", mu[1] + 0.5)
    other.until(lambda: not agree(other.pose(), pose), "the other robot does not follow")
    assert other.console_errors == []
