"""A Panda that reaches, passes and follows what people ask for."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.target import Target
from remosplat_drake.task.target_sequence import with_ways_onward

DT = 0.02
FAR = SignedDistanceField(
    PrimitiveScene(boxes=(Box(RigidTransform([9.0, 9, 9]), np.full(3, 0.1)),))
)


@pytest.fixture(scope="module")
def panda() -> RobotModel:
    return load_robot("panda")


def turned(X, angle, axis) -> np.ndarray:
    """A pose that is turned about an axis of its own frame."""
    X = X.copy()
    X[:3, :3] = X[:3, :3] @ AngleAxis(angle, np.array(axis, float)).rotation()
    return X


def moved(X, p_W) -> np.ndarray:
    X = X.copy()
    X[:3, 3] += p_W
    return X


class Loop:
    """The closed loop without a diagram, in free space or beside a box."""

    def __init__(self, robot, q=None, field=FAR):
        config = dc.replace(gain_set("tuned"), solver="active_set")
        self.law = ReactiveLaw.make(config, robot, DT)
        self.robot, self.field = robot, field
        self.q = robot.q_home if q is None else np.array(q, float)
        self.u = np.zeros(robot.n_u)
        self.poses = [self.X_WE]
        self.reports = []

    @property
    def X_WE(self) -> np.ndarray:
        return self.robot.end_effector_pose(self.q)

    @property
    def speeds(self) -> np.ndarray:
        """Speeds of the end effector, step by step [m/s]."""
        p = np.array(self.poses)[:, :3, 3]
        return np.linalg.norm(np.diff(p, axis=0), axis=1) / DT

    def tick(self, target: Target) -> None:
        clearances = self.field.clearances(self.robot.spheres_at(self.q), 0.5)
        report = run_tick(
            self.law, 0.0, self.q, target, clearances, self.field, self.u
        )
        self.u = report.command
        self.q = self.robot.advance(self.q, self.u, DT)
        self.poses.append(self.X_WE)
        self.reports.append(report)

    def drive(self, target: Target, seconds: float) -> "Loop":
        for _ in range(round(seconds / DT)):
            self.tick(target)
        return self


def test_a_position_is_reached_with_an_orientation_that_is_not(panda):
    home = Loop(panda).X_WE
    X_WT = turned(moved(home, [0.1, 0.2, -0.1]), np.pi, (1, 0, 0))
    target = Target(X_WT).without("rx", "ry", "rz")
    loop = Loop(panda).drive(target, 3.0)
    assert target.error(loop.X_WE).distance < 2e-3
    # What is not asked for is not done.
    turn = home[:3, :3].T @ loop.X_WE[:3, :3]
    assert np.arccos(0.5 * (np.trace(turn) - 1)) < 1.0
    plain = Loop(panda).drive(Target(X_WT), 3.0)
    assert Target(X_WT).error(plain.X_WE).angle < 0.1


def test_a_screw_is_reached_however_its_tool_is_turned(panda):
    home = Loop(panda).X_WE
    X_WT = turned(moved(home, [0.05, 0.2, -0.1]), 3.0, (0, 0, 1))
    target = Target(turned(X_WT, 0.2, (1, 0, 0))).without("rz")
    loop = Loop(panda).drive(target, 3.0)
    error = target.error(loop.X_WE)
    assert error.distance < 2e-3
    assert error.angle < np.radians(0.5)
    axes = loop.X_WE[:3, 2], target.X_WT[:3, 2]
    np.testing.assert_allclose(*axes, atol=0.01)
    assert loop.X_WE[:3, 0] @ target.X_WT[:3, 0] < -0.5  # Not turned round.


def test_a_free_way_is_not_gone(panda):
    home = Loop(panda).X_WE
    X_WT = moved(home, 0.15 * home[:3, 0] + 0.5 * home[:3, 1])
    loop = Loop(panda).drive(Target(X_WT).without("y"), 3.0)
    way = home[:3, :3].T @ (loop.X_WE[:3, 3] - home[:3, 3])
    assert way[0] == pytest.approx(0.15, abs=2e-3)
    assert abs(way[1]) < 0.1


def test_weights_say_what_may_be_missed(three_link):
    """Three joints cannot have a place and an orientation."""
    goal = three_link.end_effector_pose(np.array([0.4, -0.6, 0.2]))
    X_WT = turned(goal, 0.6, (0, 1, 0))
    misses = []
    for turning in (0.05, 1.0, 20.0):
        weights = np.array([turning] * 3 + [1.0] * 3)
        loop = Loop(three_link, np.zeros(3))
        loop.drive(Target(X_WT, weights), 3.0)
        error = Target(X_WT).error(loop.X_WE)
        misses.append((error.distance, error.angle))
    distances, angles = np.array(misses).T
    assert distances[0] < distances[1] < distances[2]
    assert angles[0] > angles[1] > angles[2]


def line_to(loop: Loop, p_W, speed: float, turn=0.0) -> Target:
    X_WT = turned(moved(loop.X_WE, p_W), turn, (0, 0, 1))
    return Target(X_WT).on_line(loop.X_WE, speed)


def test_a_line_is_followed_straight_and_at_its_speed(panda):
    loop = Loop(panda)
    target = line_to(loop, [0.05, 0.3, -0.1], 0.1, turn=0.8)
    length = np.linalg.norm([0.05, 0.3, -0.1])
    loop.drive(target, length / 0.1)
    beside = [target.line_deviation(X) for X in loop.poses]
    assert max(beside) < 1e-3
    told = [report.line_deviation for report in loop.reports]
    np.testing.assert_array_equal(told, beside[:-1])
    cruise = loop.speeds[30:-40]
    np.testing.assert_allclose(cruise, 0.1, rtol=0.03)
    # Halfway it has made half the turn.
    halfway = loop.poses[len(loop.poses) // 2]
    from_start = target.error(loop.poses[0]).angle
    assert target.error(halfway).angle == pytest.approx(from_start / 2, rel=0.1)
    loop.drive(target, 1.0)
    assert target.error(loop.X_WE).distance < 2e-3


def test_beside_an_obstacle_it_slows_down_and_stays_on_the_line(panda):
    """A slanted wall across the way would have the hand slide along it."""
    start = Loop(panda).X_WE
    wall = RigidTransform(
        AngleAxis(0.7, np.array([0.0, 0, 1])), start[:3, 3] + [0, 0.6, 0]
    )
    box = Box(wall, np.array([0.5, 0.15, 0.5]))
    field = SignedDistanceField(PrimitiveScene(boxes=(box,)))
    loop = Loop(panda, field=field)
    target = line_to(loop, [0.0, 0.4, 0.0], 0.2)
    loop.drive(target, 4.0)
    assert target.error(loop.X_WE).distance > 0.05
    # The arm may still move in the null space of its task.
    assert loop.speeds[-1] < 0.01
    assert max(r.line_deviation for r in loop.reports) < 4e-3
    clearances = field.clearances(panda.spheres_at(loop.q))
    assert clearances.minimum() > 0.015


def test_a_target_is_passed_without_a_stop(panda):
    first = Loop(panda)
    corner = moved(first.X_WE, [0.0, 0.25, 0.0])
    end = moved(corner, [0.1, 0.2, -0.1])
    slowest = {}
    for within in (None, 0.03):
        targets = with_ways_onward(
            [Target(corner, passed_within=within), Target(end)]
        )
        loop, passed = Loop(panda), 0
        for k in range(round(4.0 / DT)):
            error = targets[0].error(loop.X_WE)
            if not passed and targets[0].is_reached(
                error, lambda e: e.distance < 2e-3
            ):
                passed = k
            loop.tick(targets[bool(passed)])
        assert passed
        assert targets[1].error(loop.X_WE).distance < 2e-3
        slowest[within] = loop.speeds[max(passed - 15, 0) : passed + 15].min()
    speed = gain_set("tuned").servo.fastest
    assert slowest[None] < 0.1 * speed
    assert slowest[0.03] > 0.6 * speed
