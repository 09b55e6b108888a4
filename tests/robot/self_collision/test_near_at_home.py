"""Shapes that are near each other at home are watched like all others."""

import numpy as np
import pytest
from self_collision_arm import HOME, gap

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs

MARGIN = 0.01
AT_HOME = gap(HOME)


def distance(robot: RobotModel, elbow: float) -> float:
    pairs = self_collision_pairs(robot, MARGIN)
    (found,) = pairs.distances(np.array([0, elbow, 0]))
    return found


def test_shapes_that_are_apart_at_home_say_how_far(make_arm):
    robot = make_arm(AT_HOME - 0.02)
    for elbow in (HOME, 1.3, 0.2):
        expected = gap(elbow) - AT_HOME + 0.02
        assert distance(robot, elbow) == pytest.approx(expected)


def test_a_pair_that_is_near_at_home_may_come_until_it_touches(make_arm):
    assert distance(make_arm(AT_HOME - 0.004), HOME) == pytest.approx(
        0.004 + MARGIN
    )
    elbow = 2.31
    radius = gap(elbow)
    assert 0 < AT_HOME - radius < MARGIN
    assert distance(make_arm(radius), elbow) == pytest.approx(MARGIN)


def test_a_pair_that_overlaps_at_home_hardly_comes_nearer(make_arm):
    robot = make_arm(AT_HOME + 0.01)
    assert distance(robot, HOME) == pytest.approx(MARGIN + 0.005)
    assert distance(robot, 2.35) < MARGIN
