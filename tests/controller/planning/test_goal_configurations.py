"""Goal configurations, held against forward kinematics."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.goal_configurations import (
    arms_of,
    goal_configurations,
)
from remosplat_drake.controller.planning.kernels.goal_costs import goal_costs
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    Arms,
    least_manipulability,
)
from remosplat_drake.controller.planning.kernels.reaching import TOLERANCE
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target
from tests.reaching import reach


@pytest.fixture(scope="module")
def q_target(frankie) -> np.ndarray:
    q = frankie.q_home
    q[:3] = 1.0, -0.5, 0.4
    q[3:] += [0.3, 0.4, -0.2, 0.3, 0.2, -0.1, 0.5]
    return q


def free_space(robot, field, q, stopping=0.02) -> FreeSpace:
    bounds = robot.position_lower, robot.position_upper
    return FreeSpace(robot, field, stopping, None, bounds, q)


def test_solutions_reach_the_target(frankie, q_target):
    X_WT = frankie.end_effector_pose(q_target)
    target, rng = Target(X_WT), np.random.default_rng(0)
    bounds = frankie.position_lower, frankie.position_upper
    seeds = np.tile(q_target, (60, 1))
    seeds[:, 3:] += rng.normal(0, 0.7, (60, 7))
    seeds = np.clip(seeds, *bounds)
    found, error = reach(frankie, Aim.of(target), seeds, bounds)
    assert (error < TOLERANCE).sum() > 20
    assert found[:, :3] == pytest.approx(seeds[:, :3])
    assert ((found >= bounds[0]) & (found <= bounds[1])).all()
    for q, e in zip(found, error, strict=True):
        off = pose_error(frankie.end_effector_pose(q), X_WT)
        if off.angle < 3.0:
            turn = 2.0 * np.sin(0.5 * off.angle)
            assert np.hypot(off.distance, 0.3 * turn) == pytest.approx(e)


@pytest.mark.parametrize(
    "free", [("rx", "ry", "rz"), ("rz",), ("x", "ry"), ("x", "y", "z")]
)
def test_what_is_free_need_not_be_reached(frankie, q_target, free):
    target = Target(frankie.end_effector_pose(q_target)).without(*free)
    rng = np.random.default_rng(1)
    bounds = frankie.position_lower, frankie.position_upper
    seeds = np.tile(q_target, (40, 1))
    seeds[:, 3:] += rng.normal(0, 0.5, (40, 7))
    seeds = np.clip(seeds, *bounds)
    found, error = reach(frankie, Aim.of(target), seeds, bounds)
    assert (error < TOLERANCE).sum() > 20
    strays = []
    for q in found[error < TOLERANCE]:
        X_WE = frankie.end_effector_pose(q)
        off = target.error(X_WE)
        assert np.hypot(off.distance, 0.3 * off.angle) < TOLERANCE
        strays.append(pose_error(X_WE, target.X_WT))
    assert max(np.hypot(e.distance, 0.3 * e.angle) for e in strays) > 0.05


def test_goals_keep_their_distance_and_the_best_comes_first(
    frankie, empty, board_at, q_target
):
    X_WT = frankie.end_effector_pose(q_target)
    field = board_at(X_WT[2, 3] - 0.15)
    start = frankie.q_home
    space = free_space(frankie, field, start)
    goals = goal_configurations(
        space,
        X_WT,
        start,
        seeds=300,
        most=10,
        rng=np.random.default_rng(0),
    )
    assert 0 < len(goals.q) <= 10
    for q in goals.q:
        off = pose_error(frankie.end_effector_pose(q), X_WT)
        assert off.distance < TOLERANCE
        spheres = frankie.spheres_at(q)
        assert field.clearances(spheres).minimum() >= 0.02


def test_what_has_too_little_room_is_named(frankie, board_at, q_target):
    X_WT = frankie.end_effector_pose(q_target)
    field = board_at(X_WT[2, 3] - 0.01)
    start = frankie.q_home
    goals = goal_configurations(
        free_space(frankie, field, start),
        X_WT,
        start,
        seeds=200,
        most=10,
        rng=np.random.default_rng(0),
    )
    assert len(goals.q) == 0
    assert goals.reached > 0
    link = frankie.spheres.links[goals.tightest]
    assert "hand" in link or "finger" in link
    assert goals.missing > 0.01


def named(robot, q):
    return Aim(tuple(map(Target, robot.end_effector_poses(q))), q=q)


def test_a_configuration_that_is_named_is_the_only_goal(
    frankie, board_at, q_target
):
    start = frankie.q_home
    start[2] = -4.0 * np.pi + 0.1
    space = free_space(frankie, board_at(0.02), start)
    settings = {"seeds": 200, "most": 10, "rng": np.random.default_rng(0)}
    aim = named(frankie, q_target)
    (goal,) = goal_configurations(space, aim, start, **settings).q
    # The base turns by less than half a turn.
    wanted = q_target.copy()
    wanted[2] = 0.4 - 4.0 * np.pi
    assert goal == pytest.approx(wanted)


def test_a_configuration_without_room_is_no_goal(frankie, board_at, q_target):
    field = board_at(frankie.end_effector_pose(q_target)[2, 3] - 0.01)
    start = frankie.q_home
    goals = goal_configurations(
        free_space(frankie, field, start),
        named(frankie, q_target),
        start,
        seeds=200,
        most=10,
        rng=np.random.default_rng(0),
    )
    assert len(goals.q) == 0 and goals.reached == goals.seeds == 1
    assert goals.cramped == pytest.approx(q_target)
    assert goals.missing > 0.01


def test_manipulability_is_that_of_the_whole_jacobian(frankie, q_target):
    aim = Aim.of(frankie.end_effector_pose(q_target))
    bounds = frankie.position_lower, frankie.position_upper
    arms = Packed(Arms(frankie.chains, aim.arrays.values, 3, *bounds))
    stretched = q_target.copy()
    stretched[3:] = 0.0
    for q in (frankie.q_home, q_target, stretched):
        J = frankie.state(q).J_WE(0)[:, frankie.n_base :]
        m = np.sqrt(max(np.linalg.det(J @ J.T), 0.0))
        (found,) = least_manipulability(arms, q[None])
        assert found == pytest.approx(m, abs=1e-6)


def test_goals_cost_more_far_away_and_near_obstacles(frankie, q_target):
    """Times, and penalties of small margins, near limits and singularities."""
    goals = q_target + np.random.default_rng(0).normal(0, 0.2, (10, 10))
    goals = np.clip(goals, frankie.position_lower, frankie.position_upper)
    box = Box(RigidTransform([1.6, -0.2, 0.6]), np.array([0.1, 0.1, 0.6]))
    field, q = SignedDistanceField(PrimitiveScene((box,))), frankie.q_home
    space = free_space(frankie, field, q)
    arms = arms_of(space, Aim.of(frankie.end_effector_pose(q_target)))
    costs = goal_costs(space.arrays, 0, arms, goals, q)
    speed, seen = frankie.velocity_limit, set()
    for goal, cost in zip(goals, costs, strict=True):
        time = (np.abs(goal - q)[3:] / speed[2:]).max()
        time = max(time, np.hypot(*(goal - q)[:2]) / speed[0])
        margin = field.clearances(frankie.spheres_at(goal)).minimum() - 0.02
        inside = np.minimum(goal - space.lower, space.upper - goal)[3:].min()
        (m,) = least_manipulability(arms, goal[None])
        penalties = -min(margin, 0.06) / 0.02, -inside / 0.2, -m / 0.02
        expected = time + np.exp(penalties) @ [2.0, 1.0, 1.0]
        assert cost == pytest.approx(expected)
        seen.add(margin < 0.06)
    assert seen == {True, False}
