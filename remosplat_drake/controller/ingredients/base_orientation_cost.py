"""Base orientation cost: turns the base towards the end effector."""

import dataclasses as dc
import math
from typing import Annotated, NamedTuple

from annotated_types import Interval

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class BaseOrientationCostConfig(Config):
    """Settings of the cost that turns the base towards the end effector."""

    # Gain k_o of the linear cost; 0 omits the cost.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.5


class BaseOrientationCost(CompiledIngredient):
    """A linear cost that turns the base towards the end effector (J_o).

    `add_base_orientation_cost` computes it.

    Args:
        config: Gain k_o of the cost.
    """

    term = "base orientation"

    def __init__(self, config: BaseOrientationCostConfig):
        self._gain = config.gain

    def settings(self, robot: RobotModel) -> "BaseOrientationSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        return BaseOrientationSettings(self._gain)


class BaseOrientationSettings(NamedTuple):
    """Settings of a `BaseOrientationCost` for kernels."""

    gain: float


@kernel(returns=NOTHING)
def add_base_orientation_cost(own, k, tick, program):
    """Adds a linear cost that turns the base towards the end effector.

    The yaw rate has the cost

        -k_o (theta - psi)

    (paper eq. 6, J_o; after the holistic controller of Haviland, Sünderhauf and
    Corke 2022). theta is the bearing of the end effector E in the base's frame
    B. If several end effectors have targets, it is the bearing of their mean
    position. psi is the desired bearing, which guidance sets and which is
    normally zero [rad]. The cost is omitted if the robot has no base, and on a
    planned path.

    See `CompiledIngredient` for the arguments.
    """
    robot, state = tick.robot, tick.state
    if own.gain == 0.0 or robot.n_base == 0 or len(tick.guidance.path_s):
        return
    X_WB = state.X_WL[robot.body_B]
    x, y = 0.0, 0.0
    for r in range(3):
        p_WE = 0.0
        for i in tick.aim.effector:
            p_WE += state.X_WE[i, r, 3]
        p_BE_W = p_WE / len(tick.aim.effector) - X_WB[r, 3]
        x += X_WB[r, 0] * p_BE_W
        y += X_WB[r, 1] * p_BE_W
    program.has[k, 0] = True
    bearing = math.atan2(y, x)
    yaw = robot.n_base - 1
    program.linear[k, yaw] = -own.gain * (bearing - tick.guidance.bearing)
