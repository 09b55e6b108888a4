"""Motions of a base that cannot slip sideways, held against the kinematics."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.controller.planning.steering import (
    segment_command,
    waypoints,
)

PLACES = st.tuples(*3 * [st.floats(-4, 4)])


def configuration(frankie, place) -> np.ndarray:
    return np.array([*place, *frankie.home + 0.1 * place[0]])


@given(a=PLACES, b=PLACES, backing=st.sampled_from([0.0, 1.0]))
def test_commands_lead_from_corner_to_corner(frankie, a, b, backing):
    a, b = configuration(frankie, a), configuration(frankie, b)
    corners = waypoints(a, b, 2, backing)
    assert corners[0] == pytest.approx(a)
    assert np.delete(corners[-1], 2) == pytest.approx(np.delete(b, 2))
    turned = corners[-1][2] - b[2]
    assert np.cos(turned) == pytest.approx(1.0)
    for one, other in pairwise(corners):
        u = segment_command(one, other, 2)
        # The base does not drive for less than a micrometre.
        assert frankie.advance(one, u, 1.0) == pytest.approx(other, abs=1e-6)
        assert u[0] >= -backing - 1e-5


def test_the_way_back_is_driven_backwards_only_if_it_is_short(frankie):
    a = configuration(frankie, (0.0, 0.0, 0.0))
    near, far = a.copy(), a.copy()
    near[0], far[0] = -0.3, -3.0
    assert len(waypoints(a, near, 2, 0.5)) == 2
    corners = waypoints(a, far, 2, 0.5)
    assert len(corners) == 4
    assert abs(corners[1][2]) == pytest.approx(np.pi)


def test_an_arm_moves_straight(three_link):
    a, b = np.zeros(3), np.array([0.3, -0.2, 1.0])
    assert waypoints(a, b, 0, 0.0) == pytest.approx(np.array([a, b]))
    assert segment_command(a, b, 0) == pytest.approx(b)
