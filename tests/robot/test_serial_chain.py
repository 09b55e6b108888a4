"""The chain to the end effector places it as the whole tree does."""

import numpy as np
import pytest

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    Arms,
    reach_from,
)
from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.signals.aim import Aim


@pytest.mark.parametrize("name", [*shipped_robots(), "three_link"])
def test_the_end_effector_is_where_the_tree_has_it(name, three_link):
    robot = three_link if name == "three_link" else load_robot(name)
    chain = robot.chains[0]
    rng = np.random.default_rng(2)
    for _ in range(20):
        q = np.tile(rng.uniform(-2.0, 2.0, (robot.n_q, 1)), WIDTH)
        X_WT = robot.end_effector_pose(q[:, 0].copy())
        bounds = np.full(robot.n_q, -9.0), np.full(robot.n_q, 9.0)
        first = robot.n_q - len(robot.home)
        aim = Aim.of(X_WT).arrays.values
        arms = Packed(Arms((chain,), aim, first, *bounds))
        found, error = q.copy(), np.empty(WIDTH)
        reach_from(arms, found, 0, 1e-9, error)
        assert error.max() < 1e-12
        np.testing.assert_array_equal(found, q)
