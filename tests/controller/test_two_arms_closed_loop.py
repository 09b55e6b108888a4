"""Two arms on one torso that reach, wait and plan together."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.guidance.rollout import (
    REACHED,
    RUNNING,
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.goal_configurations import (
    goal_configurations,
)
from remosplat_drake.controller.planning.kernels.reaching import TOLERANCE
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target
from tests.reaching import reach

DT = 0.02
FAR = SignedDistanceField(
    PrimitiveScene(boxes=(Box(RigidTransform([9.0, 9, 9]), np.full(3, 0.1)),))
)


@pytest.fixture(scope="module")
def law(two_arms) -> ReactiveLaw:
    config = dc.replace(gain_set("tuned"), solver="active_set")
    return ReactiveLaw.make(config, two_arms, DT)


def beside(robot, effector: int, *way) -> np.ndarray:
    """A pose so far from where an end effector is at home."""
    X = robot.end_effector_pose(robot.q_home, effector)
    X[:3, 3] += way
    return X


def drive(law, aim: Aim, seconds: float):
    """The configuration at the end, and the last report."""
    robot, q = law.robot, law.robot.q_home
    u, report = np.zeros(robot.n_u), None
    for _ in range(round(seconds / DT)):
        found = FAR.clearances(robot.spheres_at(q), 0.5)
        report = run_tick(law, 0.0, q, aim, found, FAR, u)
        u = report.command
        q = robot.advance(q, u, DT)
    return q, report


def test_both_reach_what_each_is_asked_for(two_arms, law):
    aim = Aim(
        (
            Target(beside(two_arms, 0, 0.05, 0.1, 0.1)),
            Target(beside(two_arms, 1, 0.1, 0.0, -0.1)).without("rz"),
        )
    )
    q, report = drive(law, aim, 4.0)
    for error in aim.errors(two_arms.end_effector_poses(q)):
        assert error.distance < 2e-3
        assert error.angle < np.radians(0.5)
    assert report.status == "optimal"


def test_who_has_no_target_rests(two_arms, law):
    aim = Aim((None, Target(beside(two_arms, 1, 0.05, -0.05, 0.1))))
    q, _ = drive(law, aim, 4.0)
    error = aim.first.error(two_arms.end_effector_pose(q, 1))
    assert error.distance < 2e-3
    np.testing.assert_allclose(q[1:7], two_arms.home[1:7], atol=0.02)


def test_the_torso_turns_for_both(two_arms, law):
    """Both hands far to the left: no arm alone gets there."""
    turned = two_arms.q_home
    turned[0] = 1.2
    aim = Aim(tuple(map(Target, two_arms.end_effector_poses(turned))))
    q, _ = drive(law, aim, 6.0)
    assert q[0] > 0.5
    errors = aim.errors(two_arms.end_effector_poses(q))
    assert max(error.distance for error in errors) < 5e-3


def test_a_rollout_arrives_when_both_have(two_arms, law):
    near, far = beside(two_arms, 0, 0, 0, 0.02), beside(two_arms, 1, 0, 0, 0.2)
    aim = Aim((Target(near), Target(far)))
    rollout = Rollout(Guidance(), two_arms.q_home, np.zeros(two_arms.n_u))
    while rollout.status == RUNNING:
        rollout = advance_rollout(
            law, rollout, FAR, aim, lambda e: e.distance < 0.01, 5.0
        )
    assert rollout.status == REACHED
    assert rollout.time > 0.5
    for error in aim.errors(two_arms.end_effector_poses(rollout.q)):
        assert error.distance < 0.01


def test_goals_reach_both_targets_with_one_torso(two_arms):
    goal = two_arms.q_home
    goal[[0, 2, 9]] += [0.6, 0.2, -0.2]
    aim = Aim(tuple(map(Target, two_arms.end_effector_poses(goal))))
    bounds = two_arms.position_lower, two_arms.position_upper
    rng = np.random.default_rng(5)
    seeds = np.clip(goal + rng.normal(0, 0.4, (40, 13)), *bounds)
    found, error = reach(two_arms, aim, seeds, bounds)
    assert (error < TOLERANCE).sum() > 20
    for q in found[error < TOLERANCE]:
        for off in aim.errors(two_arms.end_effector_poses(q)):
            assert off.distance < TOLERANCE
    space = FreeSpace(two_arms, FAR, 0.02, None, bounds, two_arms.q_home)
    goals = goal_configurations(
        space,
        aim,
        two_arms.q_home,
        seeds=300,
        most=5,
        rng=np.random.default_rng(0),
    )
    assert len(goals.q)
