"""Free configurations and motions, against very dense checks."""

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st

import remosplat_drake as rs
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.sampling import random_states
from remosplat_drake.signals.distance_field import DistanceField

STOPPING = 0.02
JOINTS = st.tuples(*[st.floats(-limit, limit) for limit in (1.9, 2.4, 2.9)])


class OnlyPython(DistanceField):
    """A field whose answers no kernel can ask for, as one from outside."""

    def __init__(self, field: DistanceField):
        self._field = field
        self.revision = field.revision

    def clearances(self, spheres, max_distance=np.inf):
        return self._field.clearances(spheres, max_distance)


def space_of(maze, kind=None) -> FreeSpace:
    robot = maze.robot
    field = maze.field if kind is None else kind(maze.field)
    bounds = robot.position_lower, robot.position_upper
    return FreeSpace(robot, field, STOPPING, None, bounds, maze.q)


def least_clearance(maze, a, b) -> float:
    """The smallest clearance at a thousand places between a and b."""
    way = a + np.linspace(0, 1, 1001)[:, None] * (b - a)
    return min(
        maze.field.clearances(maze.robot.spheres_at(q)).minimum() for q in way
    )


@pytest.mark.parametrize("kind", [None, OnlyPython])
@settings(max_examples=effort(15, 60))
@given(a=JOINTS, b=JOINTS)
def test_motions_are_judged_as_by_looking_very_often(maze, kind, a, b):
    a, b = np.array(a), np.array(b)
    space = space_of(maze, kind)
    if not space.is_free(a):
        assert least_clearance(maze, a, a) < STOPPING
        return
    least = least_clearance(maze, a, b)
    if space.is_free_between(a, b):
        assert least >= STOPPING - TOLERANCE - 1e-9
    else:
        assert least < STOPPING + 1e-4


def test_a_forearm_through_the_block_is_seen_between_free_ends(maze):
    space = space_of(maze)
    assert space.is_free(maze.q)
    assert space.is_free(maze.q_target)
    assert not space.is_free_between(maze.q, maze.q_target)


def test_joint_limits_bound_the_space(maze):
    space = space_of(maze)
    beyond = np.array([-2.1, 0.0, 0.0])
    assert not space.is_free(beyond)
    assert not space.is_free_between(maze.q, beyond)


@settings(max_examples=effort(6, 20))
@given(arm=st.tuples(*7 * [st.floats(-1.0, 1.0)]))
def test_a_robot_keeps_off_itself_on_its_way(frankie, empty, arm):
    own = SelfClearance.make(frankie, 0.01)
    bounds = frankie.position_lower, frankie.position_upper
    a = frankie.q_home
    b = np.concatenate([a[:3], np.clip(arm + a[3:], *(x[3:] for x in bounds))])
    space = FreeSpace(frankie, empty, 0.02, own, bounds, a)
    way = a + np.linspace(0, 1, 301)[:, None] * (b - a)
    least = min(own.distances(q).min() for q in way)
    if space.is_free_between(a, b):
        assert least >= own.stopping - 0.006
    else:
        assert least < own.stopping


def test_a_robot_that_stands_too_near_may_leave(maze):
    q = np.array([-0.235, 0.0, 0.0])
    clearance = maze.field.clearances(maze.robot.spheres_at(q)).minimum()
    assert 0.0 < clearance < STOPPING
    robot = maze.robot
    bounds = robot.position_lower, robot.position_upper
    space = FreeSpace(robot, maze.field, STOPPING, None, bounds, q)
    assert space.is_free(q)
    assert space.is_free_between(q, maze.q)
    assert not space.is_free_between(q, q + np.array([0.02, 0, 0]))


@pytest.fixture(scope="module")
def panda():
    return rs.load_robot("panda", "paper")


@settings(max_examples=effort(20, 200))
@given(seed=st.integers(0, 2**32 - 1), length=st.floats(0.01, 4.0))
def test_an_arm_keeps_off_itself_as_by_looking_very_often(
    panda, empty, seed, length
):
    own = SelfClearance.make(panda, 0.01)
    bounds = panda.position_lower, panda.position_upper
    space = FreeSpace(panda, empty, 0.02, own, bounds, panda.q_home)
    a, end = random_states(panda, 2, np.random.default_rng(seed))
    b = a + min(1.0, length / np.linalg.norm(end - a)) * (end - a)
    way = a + np.linspace(0, 1, 201)[:, None] * (b - a)
    least = min(own.distances(q, 0.02).min() for q in way)
    if space.is_free(a) and space.is_free_between(a, b):
        assert least >= own.stopping - 0.006
    else:
        assert least < own.stopping + 1e-4
