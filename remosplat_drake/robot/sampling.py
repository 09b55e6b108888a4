"""Draws random configurations of a robot, within ranges of positions."""

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel


def position_ranges(robot: RobotModel) -> tuple[np.ndarray, np.ndarray]:
    """Returns the ranges of a robot's positions in random postures.

    The ranges are the joint limits, or half a turn either way for a joint or
    base without limits.

    Args:
        robot: The robot.

    Returns:
        The lower and the upper end of each range, shape (n_q,) each [m, rad].
    """
    lower, upper = robot.position_lower, robot.position_upper
    limited = np.isfinite(lower) & np.isfinite(upper)
    return np.where(limited, lower, -np.pi), np.where(limited, upper, np.pi)


def random_states(
    robot: RobotModel, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Draws configurations, uniform in their ranges, shape (count, n_q).

    Args:
        robot: The robot.
        count: Number of configurations.
        rng: Source of randomness.
    """
    return rng.uniform(*position_ranges(robot), (count, robot.n_q))
