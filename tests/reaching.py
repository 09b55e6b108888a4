"""Inverse kinematics from many seeds, for tests."""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    Arms,
    reach_from,
)
from remosplat_drake.controller.planning.kernels.reaching import TOLERANCE
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim


def reach(
    robot: RobotModel,
    aim: Aim,
    seeds: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Returns where seeds lead to, shape (k, n_q), and the errors there."""
    first = robot.n_q - len(robot.home)
    arms = Packed(Arms(robot.chains, aim.arrays.values, first, *bounds))
    # Lanes without a seed of their own start from the last one.
    most = -(-len(seeds) // WIDTH) * WIDTH
    missing = most - len(seeds)
    found = np.pad(seeds, ((0, missing), (0, 0)), mode="edge")
    error = np.empty(most)
    for first in range(0, most, WIDTH):
        some = slice(first, first + WIDTH)
        q = np.ascontiguousarray(found[some].T)
        reach_from(arms, q, 15, 0.01 * TOLERANCE, error[some])
        found[some] = q.T
    return found[: len(seeds)], error[: len(seeds)]
