"""Plans through a maze whose only way is known."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.out_of_reach import out_of_reach
from remosplat_drake.controller.planning.planning_config import PlanningConfig
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.aim import Aim

STOPPING = 0.02


def dense(path, n=2000) -> np.ndarray:
    return np.array([path.at(s) for s in np.linspace(0, path.length, n)])


def least_clearance(robot, field, path) -> float:
    return min(
        field.clearances(robot.spheres_at(q)).minimum() for q in dense(path)
    )


def test_the_only_way_through_the_maze_is_found(maze):
    plan = maze.planner().plan(maze.q, maze.X_WT, maze.field, STOPPING)
    assert plan.path is not None and plan.reason == ""
    way = dense(plan.path)
    assert way[0] == pytest.approx(maze.q)
    assert way[-1] == pytest.approx(maze.q_target, abs=0.01)
    passing = way[np.abs(way[:, 0]) < 0.01]
    assert len(passing) > 0
    assert np.abs(passing[:, 1]).min() > 1.0
    least = least_clearance(maze.robot, maze.field, plan.path)
    assert least >= STOPPING - 6e-4


def test_no_search_computes_what_depends_on_the_robot_alone():
    robot = load_robot("frankie")
    own = SelfClearance.make(robot, 0.01)
    planner = MotionPlanner(robot, own, PlanningConfig())
    known = [set(vars(thing)) for thing in (robot, own)]
    X_WT = robot.end_effector_pose(robot.q_home)
    X_WT[2, 3] -= 0.1
    nothing = SignedDistanceField(PrimitiveScene())
    assert planner.plan(robot.q_home, X_WT, nothing, STOPPING).path is not None
    assert [set(vars(thing)) for thing in (robot, own)] == known


def test_equal_searches_find_equal_paths(maze):
    planner = maze.planner(seed=5)
    one, other = (
        planner.plan(maze.q, maze.X_WT, maze.field, STOPPING) for _ in range(2)
    )
    assert np.array_equal(one.path.q, other.path.q)
    assert one.checks == other.checks


def test_a_target_that_nothing_reaches_is_called_so(maze):
    X_WT = maze.X_WT.copy()
    X_WT[1, 3] = 0.1  # The arm moves in the plane y = 0.
    plan = maze.planner(seeds=50).plan(maze.q, X_WT, maze.field, STOPPING)
    assert plan.path is None
    start = "no configuration was found that reaches the target (from"
    assert plan.reason.startswith(start)


def test_what_is_farther_than_the_arm_is_long_is_proved_to_be(maze):
    X_WT = maze.X_WT.copy()
    X_WT[0, 3] = 3.0
    plan = maze.planner().plan(maze.q, X_WT, maze.field, STOPPING)
    assert plan.path is None and plan.checks == 0
    assert plan.reason.startswith("the target is ")
    assert "m out of reach of the arm" in plan.reason
    for angle in np.linspace(-np.pi, np.pi, 9):
        stretched = np.array([angle, 0.0, 0.0])
        X_WE = maze.robot.end_effector_pose(stretched)
        assert not out_of_reach(maze.robot, Aim.of(X_WE), maze.q)


def test_a_base_does_not_drive_up(frankie):
    X_WT = frankie.end_effector_pose(frankie.q_home)
    X_WT[:2, 3] = 50.0
    assert not out_of_reach(frankie, Aim.of(X_WT), frankie.q_home)
    X_WT[2, 3] = 3.0
    reason = out_of_reach(frankie, Aim.of(X_WT), frankie.q_home)
    assert "m out of reach of the arm" in reason


def test_the_link_that_lacks_room_is_named(maze):
    inside = SignedDistanceField(
        PrimitiveScene(
            boxes=(Box(RigidTransform(maze.X_WT), np.full(3, 0.05)),)
        )
    )
    plan = maze.planner(seeds=50).plan(maze.q, maze.X_WT, inside, STOPPING)
    assert plan.path is None
    said = "keeps 20 mm from the scene: in the best one, wrist is"
    assert said in plan.reason


def test_a_search_that_ends_without_a_path_claims_nothing(maze):
    plan = maze.planner(checks=1).plan(maze.q, maze.X_WT, maze.field, STOPPING)
    assert plan.path is None
    assert "more checks may find one" in plan.reason


def test_a_search_can_be_interrupted(maze):
    plan = maze.planner().plan(
        maze.q, maze.X_WT, maze.field, STOPPING, interrupted=lambda: True
    )
    assert plan.path is None


def test_a_path_ends_where_a_new_wall_begins(maze):
    planner = maze.planner()
    path = planner.plan(maze.q, maze.X_WT, maze.field, STOPPING).path
    assert planner.open_part(path, maze.q, maze.field, STOPPING) is path
    wall = Box(RigidTransform([0.0, 0, 0.4]), np.array([1.0, 1.0, 0.1]))
    solids = (*maze.field.scene.boxes, wall)
    walled = SignedDistanceField(PrimitiveScene(boxes=solids))
    part = planner.open_part(path, maze.q, walled, STOPPING)
    assert 0 < part.length < path.length
    assert least_clearance(maze.robot, walled, part) >= STOPPING - 6e-4


def test_a_base_drives_through_the_only_door(frankie):
    def wall(y: float, half: float) -> Box:
        return Box(RigidTransform([2.0, y, 1]), np.array([0.05, half, 1]))

    room = SignedDistanceField(
        PrimitiveScene(boxes=(wall(3.0, 2.5), wall(-3.0, 2.5)))
    )
    planner = MotionPlanner(frankie, None, PlanningConfig())
    start = np.array([0.0, 1.5, np.pi, *frankie.home])
    there = np.array([4.0, -1.0, 0.0, *frankie.home])
    X_WT = frankie.end_effector_pose(there)
    path = planner.plan(start, X_WT, room, STOPPING).path
    assert path is not None
    way = dense(path)
    at_door = way[np.abs(way[:, 0] - 2.0) < 0.05]
    assert np.abs(at_door[:, 1]).max() < 0.5
    assert least_clearance(frankie, room, path) >= STOPPING - 6e-4
    step = np.diff(way, axis=0)
    slip = step[:, 1] * np.cos(way[1:, 2]) - step[:, 0] * np.sin(way[1:, 2])
    assert np.abs(slip).max() < 0.01
