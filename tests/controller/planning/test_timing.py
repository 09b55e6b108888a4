"""Speeds along paths: worked by hand for one joint, and within all limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform

from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.controller.ingredients.collision_damper import (
    approach_speed,
)
from remosplat_drake.controller.planning.blending import blended_corners
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.controllable_speeds import (
    controllable_speeds,
)
from remosplat_drake.controller.planning.steering import segment_command
from remosplat_drake.controller.planning.timing import TimingLimits, timed_path
from remosplat_drake.controller.program.kernels.path_speeds import way_ahead
from remosplat_drake.controller.program.path import Path
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

STOPPING, SHARE = 0.02, 0.9
LIMITS = TimingLimits()


@pytest.fixture(scope="module")
def panda() -> RobotModel:
    return load_robot("panda")


def space_of(robot, field, q) -> FreeSpace:
    bounds = robot.position_lower, robot.position_upper
    return FreeSpace(robot, field, STOPPING, None, bounds, q)


def test_one_joint_brakes_as_late_as_it_can():
    """A joint of 2 rad/s and 4 rad/s^2 on a way of 2 rad.

    It needs 2^2 / (2 4) = 0.5 rad to stop: up to 1.5 rad it is as fast as it
    can be, and later sqrt(2 4 left).
    """
    s = np.linspace(0.0, 2.0, 41)
    ones, zeros = np.ones((40, 1)), np.zeros((40, 1))
    v, a = controllable_speeds(
        ones, zeros, zeros, np.array([4.0]), np.diff(s), np.full(40, 2.0)
    )
    np.testing.assert_allclose(v, np.sqrt(np.minimum(4.0, 8.0 * (2.0 - s))))
    np.testing.assert_array_equal(a, 4.0)
    # From 1 rad at 2 rad/s: 0.25 s to 1.5 rad, and 0.5 s from there to rest.
    assert way_ahead(s, v, 1.0, 0.25) == pytest.approx(0.5)
    assert way_ahead(s, v, 1.0, 0.5) == pytest.approx(0.5 + 0.375)
    assert way_ahead(s, v, 1.0, 0.75) == pytest.approx(1.0)
    assert way_ahead(s, v, 1.0, 9.0) == pytest.approx(1.0)


def test_a_load_leaves_less_for_braking():
    """A torque of 3 of 10 N m at rest, and 2 N m s^2 / rad of inertia.

    Braking, the motor has 10 + 3 N m: 6.5 rad/s^2. Speeding up, 3.5 rad/s^2.
    """
    s = np.linspace(0.0, 1.0, 11)
    inertia, load = np.full((10, 1), 2.0), np.full((10, 1), 3.0)
    v, a = controllable_speeds(
        inertia,
        0.0 * load,
        load,
        np.array([10.0]),
        np.diff(s),
        np.full(10, 100.0),
    )
    np.testing.assert_allclose(v, np.sqrt(2.0 * 6.5 * (1.0 - s)))
    np.testing.assert_allclose(a, 3.5)


def corners_of(q: np.ndarray, seed: int, count: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return q + np.cumsum(rng.normal(size=(count, len(q))), axis=0) * 0.4


@given(seed=st.integers(0, 10**6), count=st.integers(2, 5))
@settings(max_examples=25, deadline=None)
def test_no_limit_is_exceeded(panda, empty, seed, count):
    """Of velocity, acceleration and torque, at the path's own speeds."""
    robot, q = panda, panda.home + 0.2
    corners = corners_of(q, seed, count)
    space = space_of(robot, empty, q)
    path = timed_path(space, blended_corners(space, corners, 1.0), LIMITS)
    assert path.v is not None
    step = np.diff(path.s)[:, None]
    rate = np.diff(path.q, axis=0) / step
    turn = np.diff(rate, axis=0, prepend=rate[:1])
    square = (path.v**2)[:, None]
    fastest = np.maximum(path.v[:-1], path.v[1:])[:, None]
    assert (np.abs(rate) * fastest <= robot.velocity_limit + 1e-6).all()
    change = np.diff(square, axis=0) / (2.0 * step)
    is_sharp = np.linalg.norm(turn, axis=1) > 0.3
    around = 0.5 * (step + np.concatenate([step[:1], step[:-1]]))
    bend = np.where(is_sharp[:, None], 0.0, turn / around)
    u_dot = rate * change + bend * square[:-1]
    most = SHARE * robot.acceleration_limit
    # Bends are those where a piece begins: so are the bounds.
    assert (np.abs(u_dot) <= most + 1e-6).all()
    jump = np.abs(turn[is_sharp]) * path.v[:-1][is_sharp, None]
    assert (jump <= most * LIMITS.dt + 1e-6).all()
    u = rate * path.v[:-1, None]
    torque = robot.dynamics.torques(path.q[:-1], u[:, None], u_dot[:, None])
    assert (np.abs(torque) <= robot.dynamics.limit).all()


def test_speeds_follow_the_dampers_law_where_room_is_small(three_link):
    """The shoulder swings the stretched arm down towards a table."""
    start, end = np.array([-0.6, 0, 0]), np.array([0.3, 0, 0])
    at_end = three_link.spheres_at(end)
    low = (at_end.p_WS[:, 2] - at_end.radius).min() - STOPPING - 0.01
    table = Box(RigidTransform([3.0, 0.0, low - 0.1]), np.array([2.5, 3, 0.1]))
    field = SignedDistanceField(PrimitiveScene(boxes=(table,)))
    space = space_of(three_link, field, start)
    path = timed_path(space, np.array([start, end]), LIMITS)
    free = timed_path(
        space_of(three_link, SignedDistanceField(PrimitiveScene()), start),
        np.array([start, end]),
        LIMITS,
    )
    assert path.v is not None and free.v is not None
    assert (path.v <= free.v + 1e-9).all()
    slower = 0
    for k in range(len(path.s) - 1):
        here, there = (three_link.spheres_at(q) for q in path.q[k : k + 2])
        lowered = (here.p_WS - there.p_WS)[:, 2] / np.diff(path.s)[k]
        room = here.p_WS[:, 2] - here.radius - low - STOPPING
        near = (room < 0.19) & (here.p_WS[:, 0] > 0.6)
        if not near.any():
            continue
        law = approach_speed(CollisionDamperConfig(), 1.0, STOPPING, room)
        allowed = (law[near] / lowered[near]).min()
        slower += allowed < free.v[k]
        assert path.v[k] <= max(allowed, 0.3) + 1e-6
    assert slower >= 3


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_blends_stay_beside_their_corners_and_are_free(maze, seed):
    planner = maze.planner(seed=seed % 7)
    plan = planner.plan(maze.q, maze.X_WT, maze.field, STOPPING)
    assert plan.corners is not None and plan.path is not None
    space = space_of(maze.robot, maze.field, maze.q)
    blended = blended_corners(space, Path.through(plan.corners).q, 0.3)
    for q in blended:
        assert maze.field.clearances(maze.robot.spheres_at(q)).minimum() >= (
            STOPPING - 6e-4
        )
    around = Path.through(plan.corners)
    # A parabola's middle is half as far from its corner as its chord is.
    assert max(around.nearest(q)[1] for q in blended) <= 0.5 * 0.3


def test_a_blend_is_shortened_until_it_is_free(three_link):
    """A post stands in the inner side of a corner."""
    corners = np.array([[-0.8, 0.0, 0], [0.0, 0.0, 0], [0.0, 0.8, 0]])
    nothing = SignedDistanceField(PrimitiveScene())
    wide = blended_corners(
        space_of(three_link, nothing, corners[0]), corners, 0.4
    )
    inside = wide[len(wide) // 2]
    p_WE = three_link.end_effector_pose(inside)[:3, 3]
    post = Box(RigidTransform(p_WE), np.full(3, 0.01))
    field = SignedDistanceField(PrimitiveScene(boxes=(post,)))
    space = space_of(three_link, field, corners[0])
    narrow = blended_corners(space, corners, 0.4)
    path = Path.through(narrow)
    assert path.nearest(inside)[1] > 1e-3
    assert path.length > Path.through(wide).length


def test_a_base_stops_where_it_goes_over_from_turning_to_driving(frankie):
    empty = SignedDistanceField(PrimitiveScene())
    arm = frankie.home
    corners = np.array(
        [
            [0, 0, 0, *arm],
            [0, 0, 1.0, *arm],
            [math.cos(1), math.sin(1), 1, *arm],
        ]
    )
    path = timed_path(space_of(frankie, empty, corners[0]), corners, LIMITS)
    assert path.v is not None
    corner = int(np.argmin(np.abs(path.s - 1.0)))
    # In a period of 0.02 s, the base changes its speed by 0.9 1.0 0.02 m/s.
    assert path.v[corner] == pytest.approx(0.018)
    u = segment_command(corners[1], corners[2], 2)
    assert u == pytest.approx([1.0, 0.0, *np.zeros(7)])
    assert path.v.max() == pytest.approx(0.87)
