"""S_p = S_h + S_r + S_s + C + Z_d + Z_r, worked by hand."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from remosplat_drake.controller.verification.protective_separation import (
    Monitoring,
    least_separation,
    protective_separation,
)
from remosplat_drake.scene.mover import Mover, Movers

AHEAD = 0.8
"""From the outermost sphere's surface to that of the mover [m]."""


@pytest.fixture
def meeting(three_link):
    """The arm along x, its shoulder turning down, and Ada below, coming up."""
    state = three_link.state(np.zeros(3))
    spheres, u = state.spheres, np.array([0.5, 0.0, 0.0])
    below = spheres.radius[-1] + AHEAD + 0.2
    ada = Mover.sphere(
        "Ada",
        spheres.p_WS[-1] - [0.0, 0.0, below],
        0.2,
        v_WM=[0.0, 0.0, 0.5],
        max_speed=2.0,
        max_acceleration=4.0,
        velocity_error=0.1,
        position_error=0.03,
    )
    return state, u, Movers(1.0, [ada])


def test_all_parts_by_hand(three_link, meeting):
    state, u, movers = meeting
    # Four ticks of 0.01 s: one with u, and three of the ramp at 3/4, 2/4, 1/4.
    limit = np.full(3, 0.5 / (4 * 0.01))
    monitoring = Monitoring.make(u, limit, 0.01, 0.05)
    assert dc.astuple(monitoring) == pytest.approx((0.05, 0.01, 0.03, 0.015))
    tube = np.full(len(state.spheres), 0.002)
    found = protective_separation(state, movers, 1.1, u, monitoring, tube)
    i = len(state.spheres) - 1
    assert found.sphere[i] == i and found.mover[i] == 0
    # Ada is seen 0.1 s late, and has come on by 0.05 m.
    assert found.distance[i] == pytest.approx(AHEAD - 0.05)
    # t = 0.04 s from now, tau = 0.14 s since her stamp: 0.5 t + 4 tau^2 / 2.
    assert found.mover_way[i] == pytest.approx(0.02 + 0.0392)
    v = -state.Jv_WS[i][2] @ u
    assert v > 0.05
    assert found.reaction_way[i] == pytest.approx(v * 0.01)
    # v (3/4 + 2/4 + 1/4) 0.01 s.
    assert found.braking_way[i] == pytest.approx(v * 0.015)
    assert found.mover_error[i] == pytest.approx(0.03 + 0.1 * 0.14)
    assert found.robot_error[i] == 0.002
    needed = 0.0592 + v * 0.025 + 0.05 + 0.044 + 0.002
    assert found.needed[i] == pytest.approx(needed)
    assert found.margin[i] == pytest.approx(AHEAD - 0.05 - needed)
    least = found.least(three_link.spheres.links, movers)
    assert least is not None
    nearest = found.sphere[found.margin.argmin()]
    assert (least.link, least.mover) == (
        three_link.spheres.links[nearest],
        "Ada",
    )
    assert least.margin == pytest.approx(found.margin.min())


def test_her_greatest_speed_bounds_her_way(meeting):
    """After a long time the bound on her speed says more."""
    state, _, movers = meeting
    rest, tube = Monitoring(0.05, 1.0, 0.0, 0.0), np.zeros(len(state.spheres))
    u = np.zeros(3)
    found = protective_separation(state, movers, 1.5, u, rest, tube)
    # V tau + v (tau - t) = 2 x 1.5 + 0.5 x 0.5 < 0.5 + 4 x 1.5^2 / 2.
    assert found.mover_way[-1] == pytest.approx(3.25)
    assert not found.reaction_way.any() and not found.braking_way.any()


def test_who_goes_away_may_turn_round(meeting):
    state, u, movers = meeting
    away = dc.replace(movers.movers[0], v_WM=np.array([0.0, 0.0, -0.5]))
    monitoring = Monitoring(0.05, 0.1, 0.1, 0.05)
    found = protective_separation(
        state,
        Movers(1.0, [away]),
        1.0,
        -u,
        monitoring,
        np.zeros(len(state.spheres)),
    )
    assert found.mover_way[-1] == pytest.approx(0.5 * 4.0 * 0.2**2)
    assert found.reaction_way[-1] == 0.0


def test_a_resting_robot_reacts_for_a_tick():
    limit = np.ones(3)
    resting = Monitoring.make(np.zeros(3), limit, 0.01, 0.05, delay=0.02)
    assert dc.astuple(resting) == pytest.approx((0.05, 0.03, 0.0, 0.0))


def test_where_nothing_moves_there_is_none(three_link, meeting):
    state, u, _ = meeting
    monitoring = Monitoring(0.05, 0.1, 0.1, 0.05)
    tube = np.zeros(len(state.spheres))
    found = protective_separation(state, Movers(1.0), 1.0, u, monitoring, tube)
    assert found.least(three_link.spheres.links, Movers(1.0)) is None
    links = three_link.spheres.links
    nothing = links, state, Movers(1.0), 1.0, u, monitoring, tube
    assert least_separation(*nothing) is None


@pytest.mark.parametrize("seed", range(20))
def test_the_compiled_form_finds_the_same_pair(three_link, seed):
    rng = np.random.default_rng(seed)
    movers = Movers(
        0.9,
        [
            Mover(
                f"mover {i}",
                RigidTransform(
                    RotationMatrix(Rotation.random(rng=rng).as_matrix()),
                    rng.uniform(-2.0, 2.0, 3),
                ),
                rng.uniform(0.0, 0.3, 3),
                rng.uniform(0.0, 0.3),
                rng.normal(size=3),
                rng.normal(size=3),
                *rng.uniform(0.0, 3.0, 2),
                *rng.uniform(0.0, 0.2, 2),
            )
            for i in range(rng.integers(1, 6))
        ],
    )
    state, u = three_link.state(rng.uniform(-2.0, 2.0, 3)), rng.normal(size=3)
    monitoring = Monitoring(*rng.uniform(0.0, 0.3, 4))
    tube = rng.uniform(0.0, 0.05, len(state.spheres))
    asked = state, movers, 1.0, u, monitoring, tube
    slow = protective_separation(*asked).least(three_link.spheres.links, movers)
    fast = least_separation(three_link.spheres.links, *asked)
    assert slow is not None and fast is not None
    assert dc.astuple(fast) == pytest.approx(dc.astuple(slow), abs=1e-12)
