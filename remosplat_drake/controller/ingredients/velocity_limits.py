"""What the actuators can do, as bounds of the program."""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.ranges import Config


@dc.dataclass
class VelocityLimitsConfig(Config):
    """Which of the robot's limits are enforced, and how much of them."""

    # Fraction of the robot's velocity limits that may be used.
    fraction: Annotated[float, Interval(gt=0, le=1)] = 1.0
    # Whether |u - u_previous| <= a_max dt is enforced.
    acceleration: bool = True
    # Bound on the base's speed backwards; absent: as fast as forwards [m/s].
    max_reverse: Annotated[float, Interval(ge=0, le=5)] | None = None


class VelocityLimits:
    """|u| <= limit, and optionally |u - u_previous| <= a_max dt.

    Backwards the base may be bounded more tightly: nobody watches there.

    A command is never clipped joint by joint afterwards: that would break
    the collision rows.
    """

    def __init__(self, config: VelocityLimitsConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Narrows the bounds of u."""
        upper = self._config.fraction * tick.robot.velocity_limit
        lower = -upper
        if self._config.max_reverse is not None and tick.robot.n_base:
            lower[0] = max(lower[0], -self._config.max_reverse)
        program.narrow(lower, upper)
        if self._config.acceleration and program.use_acceleration:
            step = tick.robot.acceleration_limit * tick.dt
            # A previous command outside the limits (their fraction may have
            # changed) must not turn the box inside out.
            anchor = np.clip(tick.u_previous, lower, upper)
            program.narrow(anchor - step, anchor + step)
            program.has_acceleration_bounds = True
