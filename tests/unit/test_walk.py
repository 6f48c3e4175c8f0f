"""A morph's PBs: from one end of a way to the other, evenly, with a rest at both."""

from __future__ import annotations

import numpy as np

from rnnpb_explorer.core.walk import morph, morph_shares


def test_it_rests_at_both_ends_and_goes_evenly_in_between() -> None:
    shares = morph_shares(9)
    np.testing.assert_allclose(shares, [0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1])
    assert morph_shares(1).tolist() == [0]


def test_a_corner_is_passed_when_as_many_steps_are_gone() -> None:
    way = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 1.0]])
    np.testing.assert_allclose(morph(way, 9)[2:7], [[0, 0], [2, 0], [4, 0], [4, 0.5], [4, 1]])
