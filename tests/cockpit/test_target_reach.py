"""Reachable targets, obstacles, and unseen space."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.cockpit.reach import (
    BLOCKED,
    OUT_OF_REACH,
    REACHABLE,
    UNSEEN_THERE,
    find_reach,
    is_within_reach,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

STOPPING = 0.02


@pytest.fixture(scope="module")
def planner() -> MotionPlanner:
    scenario = load_scenario("TableReach")
    law = ReactiveLaw.make(scenario.controller, load_robot("frankie"), 0.01)
    config = scenario.controller.guidance.planning
    return MotionPlanner(law.robot, law.self_clearance, config)


@pytest.fixture(scope="module")
def X_WT(planner) -> np.ndarray:
    """The hand's pose at home, half a metre ahead."""
    X_WT = planner.robot.end_effector_pose(planner.robot.q_home)
    X_WT[0, 3] += 0.5
    return X_WT


def scene(*boxes: Box) -> SignedDistanceField:
    far = Box(RigidTransform([0, 0, -9.0]), np.full(3, 0.1))
    return SignedDistanceField(PrimitiveScene(boxes=(far, *boxes)))


def ask(planner, field, X_WT):
    return find_reach(
        planner, field, STOPPING, planner.robot.q_home, Target(X_WT)
    )


def test_what_is_free_can_be_reached(planner, X_WT):
    reach = ask(planner, scene(), X_WT)
    assert reach.verdict == REACHABLE and reach.q is not None
    error = pose_error(planner.robot.end_effector_pose(reach.q), X_WT)
    assert error.distance < 2e-3 and error.angle < 1e-2
    again = ask(planner, scene(), X_WT)
    np.testing.assert_array_equal(reach.q, again.q)


def test_a_wall_around_the_target_is_in_the_way(planner, X_WT):
    wall = Box(RigidTransform(X_WT[:3, 3]), np.full(3, 0.1), "crate")
    reach = ask(planner, scene(wall), X_WT)
    assert reach.verdict == BLOCKED and reach.q is not None
    assert "too near to" in reach.text and "crate" in reach.text


def test_unseen_space_is_told_apart(planner, X_WT):
    unseen = np.zeros((60, 60, 40), bool)
    lower, voxel = np.array([-3.0, -3.0, -1.0]), 0.1
    cell = np.floor((X_WT[:3, 3] - lower) / voxel).astype(int)
    x, y, z = cell
    unseen[x - 1 : x + 2, y - 1 : y + 2, z - 1 : z + 2] = True
    field = UnknownSpaceField(unseen, lower, voxel)
    reach = ask(planner, field, X_WT)
    assert reach.verdict == UNSEEN_THERE and "unseen" in reach.text


def test_what_is_too_high_is_out_of_reach(planner, X_WT):
    high = X_WT.copy()
    high[2, 3] = 5.0
    reach = ask(planner, scene(), high)
    assert reach.verdict == OUT_OF_REACH and reach.q is None


def test_a_posture_that_folds_the_arm_into_itself_is_named(planner):
    robot = planner.robot
    folded = robot.q_home
    folded[3:] = np.clip(
        [0.0, 1.7, 0.0, -3.0, 0.0, 0.0, 0.0],
        robot.position_lower[3:],
        robot.position_upper[3:],
    )
    X_WT = robot.end_effector_pose(folded)
    aim = dc.replace(Aim.of(X_WT), q=folded)
    reach = find_reach(planner, scene(), STOPPING, robot.q_home, aim)
    assert reach.verdict == BLOCKED
    assert reach.text == "the robot would be too near to itself"
    plan = planner.plan(robot.q_home, aim, scene(), STOPPING)
    assert plan.path is None
    assert "links of the robot are too near to each other" in plan.reason


def test_what_no_path_leads_to_is_not_within_reach(planner, X_WT):
    q, target = planner.robot.q_home, Target(X_WT)
    assert is_within_reach(planner, scene(), STOPPING, q, target)
    beyond = X_WT.copy()
    beyond[0, 3] += 3.0
    thin, at = 0.03, 1.5
    room = [
        Box(RigidTransform([x, y, 1.5]), np.array([a, b, 1.5]))
        for x, y, a, b in (
            (at, 0.0, thin, at),
            (-at, 0.0, thin, at),
            (0.0, at, at, thin),
            (0.0, -at, at, thin),
        )
    ]
    assert ask(planner, scene(*room), beyond).verdict == REACHABLE
    target = Target(beyond)
    assert is_within_reach(planner, scene(), STOPPING, q, target)
    assert not is_within_reach(planner, scene(*room), STOPPING, q, target)
