"""Spheres that are near each other at home are watched like all others."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision import self_collision_pairs
from remosplat_drake.robot.sphere_model import SphereModel

THREE_LINK = Path(__file__).resolve().parents[1] / "data" / "three_link.yaml"
MARGIN = 0.01


def three_link(radius: float) -> RobotModel:
    """A sphere of this radius on the upper arm, two small ones elsewhere."""
    spheres = SphereModel(
        "x",
        ("upper_arm", "upper_arm", "wrist"),
        np.array([[0.3, 0, 0], [0, 0, 0], [0, 0, 0.0]]),
        np.array([radius, 0.05, 0.05]),
    )
    return RobotModel(load_robot_description(THREE_LINK), spheres)


def gap(elbow: float, x: float) -> float:
    """From the wrist to a point x along the upper arm of 0.5 m."""
    return np.hypot(0.5 + 0.4 * np.cos(elbow) - x, 0.4 * np.sin(elbow))


def distances(robot: RobotModel, elbow: float) -> list[float]:
    pairs = self_collision_pairs(robot, MARGIN)
    near = pairs.nearest(robot.spheres_at(np.array([0, elbow, 0])), 2.0)
    return near.distance.tolist()


HOME = 1.2
AT_HOME = gap(HOME, 0.3) - 0.05


def test_spheres_that_are_apart_at_home_say_how_far():
    robot = three_link(AT_HOME - 0.02)
    for elbow in (HOME, 1.3):
        expected = gap(elbow, 0.3) - AT_HOME + 0.02 - 0.05
        assert distances(robot, elbow) == pytest.approx([expected])


def test_a_pair_that_is_near_at_home_may_come_until_it_touches():
    robot = three_link(AT_HOME - 0.004)
    big, small = distances(robot, HOME)[::-1]
    assert big == pytest.approx(0.004 + MARGIN)
    assert small == pytest.approx(gap(HOME, 0.0) - 0.1)
    elbow = 1.25
    touching = gap(elbow, 0.3) - 0.05
    assert distances(three_link(touching), elbow)[1] == pytest.approx(MARGIN)


def test_a_pair_that_overlaps_at_home_hardly_comes_nearer():
    robot = three_link(AT_HOME + 0.03)
    assert distances(robot, HOME)[1] == pytest.approx(MARGIN + 0.005)
    assert distances(robot, 1.25)[1] < MARGIN
