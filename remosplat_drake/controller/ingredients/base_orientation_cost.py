"""Turn the base towards the end effector."""

import dataclasses as dc
import math
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick


@dc.dataclass
class BaseOrientationCostConfig(Config):
    """How eagerly the base faces the end effector."""

    # Gain of the linear cost; 0 leaves it out.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.5


class BaseOrientationCost:
    """-gain (theta - psi) on the yaw rate, theta the bearing of E in B.

    psi is the guidance's bearing, normally zero. After Haviland's holistic
    controller (paper eq. 6, J_o). A robot without a base is left alone.
    """

    def __init__(self, config: BaseOrientationCostConfig):
        self._gain = config.gain

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost."""
        if self._gain == 0.0 or tick.robot.n_base == 0:
            return
        X_WB, X_WE = tick.state.X_WB, tick.state.X_WE
        p_BE_B = X_WB[:3, :3].T @ (X_WE[:3, 3] - X_WB[:3, 3])
        c = np.zeros(program.n_u)
        theta = math.atan2(p_BE_B[1], p_BE_B[0])
        c[1] = -self._gain * (theta - tick.guidance.bearing)
        program.add_linear_cost("base orientation", c)
