"""Distances of points beyond the reach of an arm."""

import numpy as np
import pytest

from remosplat_drake.robot.reach import (
    beyond_reach,
    end_effector_reach,
    shoulder,
)
from remosplat_drake.robot.robot_model import load_robot


@pytest.mark.parametrize("model", ["panda", "frankie"])
def test_a_point_straight_above_is_out_of_reach_by_what_is_lacking(model):
    robot = load_robot(model)
    q = robot.q_home
    far = shoulder(robot, q)
    far[2] += end_effector_reach(robot) + 0.3
    assert beyond_reach(robot, q, far) == pytest.approx(0.3)
    assert beyond_reach(robot, q, far - [0.0, 0.0, 0.4]) == 0.0


def test_a_base_drives_to_what_is_far_ahead():
    robot = load_robot("frankie")
    q = np.array([0.0, 0.0, 0.0, *robot.home])
    far = np.array([9.0, 0.0, 0.5])
    assert beyond_reach(robot, q, far) == 0.0
    assert beyond_reach(robot, q, far, parked=True) > 7.0
