"""How far a point is beyond an arm."""

import numpy as np
import pytest

from remosplat_drake.robot.reach import arm_reach, beyond_reach, shoulder
from remosplat_drake.robot.robot_model import load_robot


@pytest.mark.parametrize("model", ["panda", "frankie"])
def test_a_point_straight_above_is_out_of_reach_by_what_is_lacking(model):
    robot = load_robot(model)
    q = np.array([*[0.0] * robot.n_base, *robot.home])
    up = np.array([0.0, 0.0, 1.0])
    far = shoulder(robot, q) + (arm_reach(robot) + 0.3) * up
    assert beyond_reach(robot, q, far) == pytest.approx(0.3)
    assert beyond_reach(robot, q, far - 0.4 * up) == 0.0


def test_a_base_drives_to_what_is_far_ahead():
    robot = load_robot("frankie")
    q = np.array([0.0, 0.0, 0.0, *robot.home])
    assert beyond_reach(robot, q, np.array([9.0, 0.0, 0.5])) == 0.0
