"""Paths that keep away from movers: by hand, and against dense checks."""

import mover_sweep_reference
import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation
from verified_commands import make_path as path_of

from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.kernels.mover_sweep import (
    keeps_off_movers,
)
from remosplat_drake.controller.verification.kernels.places import PathArrays
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.kernels.mover_reach import near_movers
from remosplat_drake.scene.mover import Mover, Movers

DT = 0.01
SEPARATION = 0.05
STILL = {"max_speed": 0.0, "max_acceleration": 0.0}


def keeps_off(robot: RobotModel, q, u, movers, separation=SEPARATION) -> bool:
    path = make_path(robot, q, u)
    return keeps_off_movers(
        robot.arrays,
        path,
        Movers(0.0, movers).at(0.0),
        robot.spheres_at(np.array(q, float)).p_WS.copy(),
        separation,
        np.zeros(len(robot.spheres)),
        TOLERANCE,
    )


def make_path(robot: RobotModel, q, u) -> PathArrays:
    return path_of(robot.arrays, q, u, DT)


def tip(robot: RobotModel, q) -> tuple[np.ndarray, float]:
    """Where the outermost sphere is, and its radius."""
    spheres = robot.spheres_at(np.array(q, float))
    outermost = np.linalg.norm(spheres.p_WS, axis=1).argmax()
    return spheres.p_WS[outermost], float(spheres.radius[outermost])


def beside_tip(robot: RobotModel, q, u, gap: float, sense: float = 1.0):
    """Where a ball of 0.1 m is that the tip moves towards, or away from."""
    p, radius = tip(robot, q)
    ahead = tip(robot, np.array(q) + 1e-6 * np.array(u))[0] - p
    ahead /= np.linalg.norm(ahead)
    return p + sense * (radius + 0.1 + gap) * ahead


Q, U = [0.3, -0.8, 0.2], [0.0, 0.0, 0.5]


def test_nothing_moves_that_is_far(three_link):
    ball = Mover.sphere("ball", [9.0, 0, 0], 0.1)
    assert keeps_off(three_link, Q, U, [ball])
    assert keeps_off(three_link, Q, U, [])


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.045])
def test_the_robot_does_not_approach_what_is_too_near(three_link, gap):
    ball = Mover.sphere("ball", beside_tip(three_link, Q, U, gap), 0.1, **STILL)
    assert not keeps_off(three_link, Q, U, [ball])
    assert keeps_off(three_link, Q, np.zeros(3), [ball])  # it may rest


def test_it_retreats_even_from_what_comes(three_link):
    p = beside_tip(three_link, Q, U, 0.001, sense=-1.0)
    towards = tip(three_link, Q)[0] - p
    towards /= np.linalg.norm(towards)
    ball = Mover.sphere("ball", p, 0.1, v_WM=0.3 * towards)
    assert keeps_off(three_link, Q, U, [ball])
    assert not keeps_off(three_link, Q, -np.array(U), [ball])


def test_what_comes_is_seen_before_it_is_there(three_link):
    """The tip moves by; the ball will be in its way, or has passed."""
    p = beside_tip(three_link, Q, U, 0.07)
    towards = tip(three_link, Q)[0] - p
    towards /= np.linalg.norm(towards)
    for speed, expected in ((0.0, True), (1.0, False), (-1.0, True)):
        ball = Mover.sphere(
            "ball", p, 0.1, v_WM=speed * towards, max_acceleration=0.0
        )
        assert keeps_off(three_link, Q, U, [ball]) is expected


def test_what_may_start_suddenly_needs_more_room(three_link):
    u = [0.0, 0.0, 1.0]
    ramp = make_path(three_link, Q, u).clock[-1]
    p = beside_tip(three_link, Q, u, 0.08)
    for most, expected in ((0.0, True), (4 * 0.05 / ramp**2, False)):
        ball = Mover.sphere("ball", p, 0.1, max_acceleration=most)
        assert keeps_off(three_link, Q, u, [ball]) is expected


def draw(rng, robot: RobotModel):
    """A configuration, a command, and some movers near the arm."""
    q = rng.uniform(robot.position_lower, robot.position_upper)
    u = rng.uniform(-1, 1, robot.n_u) * robot.velocity_limit
    u *= rng.choice([0.2, 1.0])
    p_WS = robot.spheres_at(q).p_WS
    movers = []
    for _ in range(rng.integers(1, 4)):
        center = p_WS[rng.integers(len(p_WS))] + rng.uniform(-0.5, 0.5, 3)
        turned = RotationMatrix(Rotation.random(rng=rng).as_matrix())
        half = rng.uniform(0, 0.2, 3) * rng.integers(0, 2, 3)
        movers.append(
            Mover(
                "it",
                RigidTransform(turned, center),
                half,
                rng.uniform(0, 0.1),
                rng.uniform(-1, 1, 3),
                rng.uniform(-1, 1, 3),
                max_acceleration=rng.choice([0.0, 1.0, 5.0]),
            )
        )
    return q, u, movers


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=effort(60, 300))
def test_what_passes_is_clear_or_retreats_at_all_times(three_link, seed):
    """Seen in steps of a millisecond, along the path as it is executed."""
    robot, rng = three_link, np.random.default_rng(seed)
    q, u, movers = draw(rng, robot)
    if not keeps_off(robot, q, u, movers):
        return
    path, field = make_path(robot, q, u), Movers(0.0, movers)
    clock = np.append(0.0, path.clock)
    times = np.append(0.0, path.times)
    now = np.arange(0.0, clock[-1] + 1e-9, 1e-3)
    spheres = robot.spheres_at(q)
    level = distances(field, 0.0, spheres.p_WS, spheres.radius)[0]
    level = np.minimum(np.maximum(level, TOLERANCE), SEPARATION)
    before = spheres.p_WS
    for t in now[1:]:
        there = robot.advance(q, u, float(np.interp(t, clock, times)))
        p_WS = robot.spheres_at(there).p_WS
        distance, n = distances(field, t, p_WS, spheres.radius)
        moved = p_WS - before
        ahead = np.einsum("kni,ni->kn", n, moved)
        moves = np.linalg.norm(moved, axis=1) > 1e-7
        near = (distance < level - TOLERANCE - 1e-9) & moves
        assert (ahead[near] <= 1e-12).all()
        before = p_WS


@given(seed=st.integers(0, 2**32 - 1), age=st.floats(0.0, 0.2))
@settings(max_examples=effort(25, 100), deadline=None)
def test_the_kernel_decides_as_its_reference(three_link, seed, age):
    q, u, movers = draw(np.random.default_rng(seed), three_link)
    path, field = make_path(three_link, q, u), Movers(0.0, movers)
    decided = keeps_off_movers(
        three_link.arrays,
        path,
        field.at(age),
        three_link.spheres_at(q).p_WS.copy(),
        SEPARATION,
        np.zeros(len(three_link.spheres)),
        TOLERANCE,
    )
    assert decided == mover_sweep_reference.keeps_off_movers(
        three_link, path, field, age, SEPARATION, TOLERANCE
    )


def distances(movers: Movers, t: float, p_WS, radius):
    """Distances of all movers from all spheres, and directions to them."""
    k, n = len(movers), len(p_WS)
    sphere, which, distance, n_W, _ = near_movers(
        movers.at(t), np.ascontiguousarray(p_WS), radius.copy(), np.inf, 0.0
    )
    found, direction = np.empty((k, n)), np.empty((k, n, 3))
    found[which, sphere], direction[which, sphere] = distance, n_W
    return found, direction


def test_not_everything_is_refused(three_link):
    """So the test above looks at something, close by as well."""
    passed, close = 0, 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        q, u, movers = draw(rng, three_link)
        if keeps_off(three_link, q, u, movers):
            passed += 1
            spheres = three_link.spheres_at(q)
            field = Movers(0.0, movers)
            near, _ = distances(field, 0.0, spheres.p_WS, spheres.radius)
            close += bool(near.min() < 0.15)
    assert 100 < passed < 250 and close > 20
