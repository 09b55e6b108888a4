"""Contacts by hand: an arm on a lift, and balls that meet it or not."""

import tracemalloc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.recording.mover_contacts import (
    RESTING,
    RETREATING,
    TOWARDS,
    distances,
    judge_movers,
)
from remosplat_drake.scene.kernels.mover_reach import near_movers
from remosplat_drake.scene.mover import Mover, Movers

DT = 0.1
RADIUS = 0.05
TOUCH = 0.11 + RADIUS
"""Distance of centres at which a forearm's sphere at x = 0.6 touches [m]."""


def lifted(*heights: float) -> np.ndarray:
    """Configurations at which that sphere is so high above 1 m."""
    return np.array([[height, 0.0, 0.0, 0.0] for height in heights])


def judge(robot, q, position, dt=DT, **rest):
    """A ball whose centre is where a function of time says."""

    def movers(time: float) -> Movers:
        ball = Mover.sphere("ball", position(time), RADIUS, **rest)
        return Movers(time, [ball])

    return judge_movers(robot, dt * np.arange(len(q) - 1), q, movers, dt)


def test_who_rises_to_what_stands_is_at_fault(lift_arm):
    q = lifted(*np.linspace(0.0, 0.3, 31))
    judged = judge(lift_arm, q, lambda t: [0.6, 0.0, 1.2 + TOUCH])
    (contact,) = judged.contacts
    assert (contact.link, contact.mover) == ("forearm", "ball")
    assert contact.kind == judged.worst == TOWARDS
    # At 0.1 m/s after 0.2 m, and then until the end.
    assert contact.start == pytest.approx(2.0, abs=1e-3)
    assert contact.end == pytest.approx(3.0)
    assert contact.depth == pytest.approx(0.1)
    assert judged.distance[0] == pytest.approx(0.2)
    assert judged.waited == 0.0


def test_who_stands_is_touched_at_rest(lift_arm):
    q = lifted(*np.zeros(31))
    judged = judge(lift_arm, q, lambda t: [0.6, 0.0, 1.5 - 0.2 * t])
    assert judged.worst == RESTING
    assert judged.contacts[0].start == pytest.approx(
        (0.5 - TOUCH) / 0.2, abs=1e-3
    )
    assert judged.waited == pytest.approx(3.0)


def test_who_goes_down_before_it_retreats(lift_arm):
    """It is caught up with for a moment, by what then lets it go."""
    q = lifted(*np.linspace(0.3, 0.0, 31))
    judged = judge(lift_arm, q, lambda t: [0.6, 0.0, 1.32 + 0.4 * abs(t - 1.2)])
    assert [c.kind for c in judged.contacts] == [RETREATING]


def test_the_worst_counts(lift_arm):
    """Touched at rest, it then rises into what touches it."""
    q = lifted(*np.zeros(20), *np.linspace(0.01, 0.1, 10))
    judged = judge(lift_arm, q, lambda t: [0.6, 0.0, 1.0 + TOUCH - 0.01])
    (contact,) = judged.contacts
    assert (contact.kind, contact.start) == (TOWARDS, 0.0)
    assert judged.count(RESTING) == 0


@pytest.mark.parametrize("speed", [3.0, 20.0])
def test_what_passes_between_two_looks_is_found(lift_arm, speed):
    """It grazes the arm by a millimetre for a hundredth of a second at most."""
    q, height = lifted(0.0, 0.0), 1.0 + TOUCH - 1e-3

    def passing(time):
        return [0.6, speed * (time - 0.0437), height]

    (contact,) = judge(lift_arm, q, passing).contacts
    assert contact.start == pytest.approx(0.0437, abs=0.01)
    assert contact.kind == RESTING
    assert not judge(
        lift_arm, q, lambda t: [*passing(t)[:2], height + 2e-3]
    ).contacts


def test_a_turning_box_is_found_between_two_looks(lift_arm):
    """Its end sweeps through the arm within a tick."""
    q = lifted(0.0, 0.0)

    def movers(time: float) -> Movers:
        turn = RollPitchYaw(0.0, 0.0, 20.0 * (time - 0.063))
        X_WM = RigidTransform(turn, [1.95, 0.0, 1.0])
        return Movers(time, [Mover.box("bar", X_WM, [1.0, 0.01, 0.01])])

    judged = judge_movers(lift_arm, np.zeros(1), q, movers, DT)
    assert {c.link for c in judged.contacts} >= {"wrist"}


def test_a_long_run_is_judged_in_no_more_memory(lift_arm):
    """The looks of a minute alone would be many megabytes."""

    def peak(ticks: int) -> int:
        crowd = [Mover.sphere("ball", [k, 0.0, 3.0], RADIUS) for k in range(90)]
        q = lifted(*np.zeros(ticks + 1))
        tracemalloc.start()
        try:
            judge_movers(
                *(lift_arm, DT * np.arange(ticks), q),
                *(lambda time: Movers(time, crowd), DT),
            )
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(10)
    assert peak(150) < peak(50) + 100_000


def test_nothing_moves(lift_arm):
    judged = judge_movers(lift_arm, np.zeros(1), lifted(0.0, 0.1), Movers, DT)
    assert judged.contacts == () and judged.worst == ""
    assert np.isinf(judged.distance).all()


def test_distances_are_those_that_the_robot_is_told():
    rng = np.random.default_rng(3)
    movers = Movers(
        0.0,
        [
            Mover(
                "it",
                RigidTransform(RollPitchYaw(rng.uniform(-3, 3, 3)), p),
                np.array(size, float),
                0.1,
            )
            for p, size in zip(
                0.5 * rng.normal(size=(4, 3)),
                ([0, 0, 0], [0, 0, 0.3], [0.2, 0.3, 0], [0.3, 0.2, 0.4]),
                strict=True,
            )
        ],
    )
    p_WS = 0.5 * rng.normal(size=(50, 3))
    radius = rng.uniform(0.01, 0.1, 50)
    distance, towards_W = distances(movers.at(0.0), p_WS, radius)
    sphere, mover, known, direction_W, _ = near_movers(
        movers.at(0.0), p_WS, radius, 1e3, 0.0
    )
    np.testing.assert_allclose(distance[mover, sphere], known, atol=1e-12)
    np.testing.assert_allclose(
        towards_W[mover, sphere], direction_W, atol=1e-12
    )
    assert (distance < 0.0).any()
