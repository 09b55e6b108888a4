"""Turn the base towards the end effector."""

import dataclasses as dc
import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class BaseOrientationCostConfig(Config):
    """Settings of the cost that turns the base towards the end effector."""

    # Gain k_o of the linear cost; 0 leaves the cost out.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.5


class BaseOrientationCost(CompiledIngredient):
    """A linear cost that turns the base towards the end effector.

    The yaw rate costs -k_o (theta - psi): theta is the bearing of the end
    effector E (of several that have targets, of their middle) in the base B,
    psi that which guidance wants, normally zero
    [rad] (paper eq. 6, J_o; after the holistic controller of Haviland,
    Sünderhauf and Corke 2022). For a robot without a base there is no cost.

    Args:
        config: Gain k_o of the cost.
    """

    term = "base orientation"

    def __init__(self, config: BaseOrientationCostConfig):
        self._gain = config.gain

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost on the yaw rate.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the poses of base and end
                effector and the guidance's bearing matter here.
        """
        if self._gain == 0.0 or tick.robot.n_base == 0:
            return
        if tick.guidance.path is not None:
            return
        X_WB = tick.state.X_WB
        aimed = [i for i, _ in tick.aim.items]
        p_WE = tick.state.X_WEs[aimed, :3, 3].mean(axis=0)
        p_BE_B = X_WB[:3, :3].T @ (p_WE - X_WB[:3, 3])
        c = np.zeros(program.n_u)
        theta = math.atan2(p_BE_B[1], p_BE_B[0])
        c[tick.robot.n_base - 1] = -self._gain * (theta - tick.guidance.bearing)
        program.add_linear_cost(self.term, c)

    def settings(self, robot: RobotModel) -> "BaseOrientationSettings":
        """Makes what the kernel takes; see `CompiledIngredient`."""
        return BaseOrientationSettings(self._gain)


class BaseOrientationSettings(NamedTuple):
    """Settings of the BaseOrientationCost, for kernels."""

    gain: float


@helper
def add_base_orientation_cost(own, k, tick, program):
    """Adds a `BaseOrientationCost`; see `kernels/assemble.py`."""
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
