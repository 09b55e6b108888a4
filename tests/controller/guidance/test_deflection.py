"""The bend of the servo's velocity, worked out on paper."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from programs import program_of

from remosplat_drake.controller.ingredients import (
    BaseOrientationCost,
    BaseOrientationCostConfig,
)
from remosplat_drake.controller.ingredients.deflection import (
    NEAR,
    deflection,
)
from remosplat_drake.controller.program.guidance import (
    DIRECT,
    Guidance,
    make_candidates,
)

STOPPING, MAX_SPEED = 0.02, 0.35
LEFT, RIGHT = Guidance("left", 1.0), Guidance("right", -1.0)
AHEAD = np.array([1.0, 0.0, 0.0])
DOWN = np.array([0.0, 0.0, -1.0])


def bend(
    v,
    guidance,
    *,
    distance,
    towards,
    to_target,
    leading=(True,),
    stopping=STOPPING,
) -> np.ndarray:
    """One row a sphere; `towards` points from the spheres to the scene."""
    distance, towards = np.atleast_1d(distance), np.atleast_2d(towards)
    return deflection(
        v,
        np.array(to_target, float),
        (np.arange(len(distance)), distance, towards),
        np.array(leading),
        guidance.side,
        stopping,
        MAX_SPEED,
    )


def test_an_obstacle_straight_ahead_is_passed_on_the_named_side():
    v = 0.1 * AHEAD
    for guidance, y in ((LEFT, 1.0), (RIGHT, -1.0)):
        bent = bend(
            v,
            guidance,
            distance=STOPPING,
            towards=AHEAD,
            to_target=[0.3, 0, 0],
        )
        # At the stopping distance the bend is complete, and brings speed.
        np.testing.assert_allclose(
            bent, [0, 0.6 * MAX_SPEED * y, 0], atol=1e-15
        )


def test_half_way_in_strength_it_turns_by_45_degrees():
    half = 0.5 * (STOPPING + NEAR)
    bent = bend(
        MAX_SPEED * AHEAD,
        LEFT,
        distance=half,
        towards=AHEAD,
        to_target=[0.3, 0, 0],
    )
    expected = MAX_SPEED * np.array([1, 1, 0]) / np.sqrt(2)
    np.testing.assert_allclose(bent, expected, atol=1e-15)


@pytest.mark.parametrize("tier", [0.021, 0.010])
def test_nearness_is_measured_from_the_tier_in_use(tier):
    bent = bend(
        AHEAD,
        LEFT,
        distance=0.05,
        towards=AHEAD,
        to_target=0.3 * AHEAD,
        stopping=tier,
    )
    w = (NEAR - 0.05) / (NEAR - tier)
    assert bent[1] / bent[0] == pytest.approx(w / (1 - w))


def test_the_table_under_the_target_is_not_in_the_way():
    # 50 mm above the table, on the way to 30 mm above it.
    v = np.array([0.1, 0.0, -0.01])
    bent = bend(v, LEFT, distance=0.05, towards=DOWN, to_target=[0.2, 0, -0.02])
    assert bent is v


def test_what_lies_behind_is_not_in_the_way():
    v = 0.1 * AHEAD
    assert (
        bend(v, LEFT, distance=0.03, towards=-AHEAD, to_target=[0.3, 0, 0]) is v
    )


@pytest.mark.parametrize(
    "change",
    [
        {"guidance": DIRECT},
        {"distance": NEAR},
        {"leading": (False,)},
        {"v": np.zeros(3)},
    ],
)
def test_nothing_to_bend_returns_the_very_same_vector(change):
    arguments = {
        "v": 0.1 * AHEAD,
        "guidance": LEFT,
        "distance": 0.03,
        "towards": AHEAD,
        "to_target": [0.3, 0, 0],
        **change,
    }
    assert bend(**arguments) is arguments["v"]


def test_a_ceiling_has_no_side():
    # Pressing straight down on something flat: n x z = 0.
    v = 0.1 * DOWN
    bent = bend(
        v, LEFT, distance=STOPPING, towards=DOWN, to_target=[0, 0, -0.3]
    )
    assert bent is v


def test_walls_on_both_sides_have_no_common_side():
    v = 0.1 * AHEAD
    walls = np.array([[0.0, 1, 0], [0.0, -1, 0]])
    bent = bend(
        v,
        LEFT,
        distance=[0.03, 0.03],
        towards=walls,
        to_target=[0.3, 0, 0],
        leading=(True, True),
    )
    assert bent is v


def test_the_nearest_of_several_decides_most():
    towards = np.array([[1.0, 0, 0], [0.8, 0.6, 0]])
    bent = bend(
        0.1 * AHEAD,
        LEFT,
        distance=[STOPPING, 0.06],
        towards=towards,
        to_target=[0.5, 0, 0],
        leading=(True, True),
    )
    n = -(towards[0] + 0.5**3 * towards[1])
    n /= np.linalg.norm(n)
    np.testing.assert_allclose(
        bent, 0.6 * MAX_SPEED * np.array([n[1], -n[0], 0]), atol=1e-15
    )


@given(
    distance=st.floats(0.0, NEAR),
    azimuth=st.floats(-3.1, 3.1),
    climb=st.floats(-1.0, 1.0),
    side=st.sampled_from([-1.0, 1.0]),
)
@settings(max_examples=60)
def test_the_bend_is_continuous(distance, azimuth, climb, side):
    horizontal = np.cos(climb)

    def bent(d):
        return bend(
            0.1 * AHEAD,
            Guidance("side", side),
            distance=d,
            towards=[
                horizontal * np.cos(azimuth),
                horizontal * np.sin(azimuth),
                np.sin(climb),
            ],
            to_target=[0.2, 0.05, 0],
        )

    before, after = bent(distance), bent(distance + 1e-7)
    np.testing.assert_allclose(before, after, atol=1e-5)
    assert np.linalg.norm(before) <= max(0.1, 0.6 * MAX_SPEED) + 1e-12


def test_the_base_heads_for_the_side_that_is_taken(frankie, make_tick):
    """At rest, the bearing term turns the base left for "left"."""
    q = np.array([0, 0, 0, *frankie.home])
    costs = {}
    for guidance in make_candidates([STOPPING])[0]:
        tick = dc.replace(make_tick(frankie, q), guidance=guidance)
        cost = BaseOrientationCost(BaseOrientationCostConfig(gain=0.5))
        program = program_of(tick, [cost])
        (c,) = program.terms.linear.values()
        costs[guidance.name] = c[1]
    # A negative cost on the yaw rate turns left; E is straight ahead.
    assert costs["left"] == pytest.approx(-0.4, abs=1e-6)
    assert costs["right"] == pytest.approx(0.4, abs=1e-6)
    assert costs["direct"] == pytest.approx(0.0, abs=1e-6)
