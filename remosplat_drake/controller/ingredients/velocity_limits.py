"""Velocity limits: bounds the command by the limits of the actuators."""

import dataclasses as dc
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.kernels.tick_arrays import narrow
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class VelocityLimitsConfig(Config):
    """Settings of the bounds of the command."""

    # Fraction of the robot's velocity and acceleration limits that the program
    # may use. Braking ramps always use the full deceleration.
    fraction: Annotated[float, Interval(gt=0, le=1)] = 1.0
    # Whether the acceleration limits bound the change of the command:
    # |u - u_previous| <= a_max dt.
    acceleration: bool = True
    # Whether acceleration bounds hold even if no command within them satisfies
    # all rows. If so, rows are relaxed, or the robot brakes. If not, the
    # acceleration bounds are dropped. They always hold on a real robot.
    strict: bool = False
    # Bound of the base's forward speed [m/s]; if absent, the robot's limit.
    max_forward: Annotated[float, Interval(ge=0, le=5)] | None = None
    # Bound of the base's backward speed [m/s]; if absent, the robot's limit.
    max_reverse: Annotated[float, Interval(ge=0, le=5)] | None = None
    # Bound of the sideways speed of an omnidirectional base [m/s]; if absent,
    # the robot's limit.
    max_sideways: Annotated[float, Interval(ge=0, le=5)] | None = None
    # Bound of the base's yaw rate [rad/s]; if absent, the robot's limit.
    max_yaw_rate: Annotated[float, Interval(ge=0, le=20)] | None = None

    def is_parked(self, n_base: int) -> bool:
        """Returns whether the bounds allow no motion of the base.

        Args:
            n_base: Number of the base's commands.
        """
        lower, upper = self.base_bounds(n_base)
        return n_base > 0 and not (lower.any() or upper.any())

    def base_bounds(self, n_base: int) -> tuple[np.ndarray, np.ndarray]:
        """Returns the additional lower and upper bounds of the base's commands.

        Args:
            n_base: Number of the base's commands.

        Returns:
            Lower and upper bounds, each of shape (n_base,) [m/s, rad/s];
            infinite if there is no bound.
        """
        forward, reverse, aside, yaw_rate = (
            np.inf if bound is None else bound
            for bound in (
                self.max_forward,
                self.max_reverse,
                self.max_sideways,
                self.max_yaw_rate,
            )
        )
        kept = {3: [0, 1, 2], 2: [0, 2], 0: []}[n_base]
        upper = np.array([forward, aside, yaw_rate])
        lower = np.array([-reverse, -aside, -yaw_rate])
        return lower[kept], upper[kept]


class VelocityLimits(CompiledIngredient):
    """Bounds of the command, which `add_velocity_limits` computes.

    Args:
        config: The limits to enforce, and the usable fraction.

    Attributes:
        config: The limits to enforce, and the usable fraction.
    """

    term = "velocity limits"

    def __init__(self, config: VelocityLimitsConfig):
        self.config = config

    def settings(self, robot: RobotModel) -> "VelocityLimitsSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config = self.config
        return VelocityLimitsSettings(
            config.fraction,
            *config.base_bounds(robot.n_base),
            config.acceleration,
        )


class VelocityLimitsSettings(NamedTuple):
    """Settings of a `VelocityLimits` for kernels."""

    fraction: float
    base_lower: np.ndarray
    base_upper: np.ndarray
    acceleration: bool


@kernel(returns=NOTHING)
def add_velocity_limits(own, k, tick, program):
    """Bounds the command by the limits of the actuators.

    With the fraction f of the robot's limits u_max [rad/s, m/s] and, if
    `acceleration` is set, a_max [rad/s^2, m/s^2],

        |u| <= f u_max,    |u - u_previous| <= f a_max dt

    The base may have tighter bounds, for example of its backward speed if no
    safety sensor looks backwards. In the second inequality, u_previous is first
    clipped to the bounds of the first inequality: f may have changed, and both
    inequalities must be feasible together. The solution is never clipped joint
    by joint, since a clipped command could violate the collision rows.

    See `CompiledIngredient` for the arguments.
    """
    robot = tick.robot
    upper = own.fraction * robot.velocity_limit
    lower = -upper
    for j in range(robot.n_base):
        lower[j] = max(lower[j], own.base_lower[j])
        upper[j] = min(upper[j], own.base_upper[j])
    narrow(program, lower, upper, False)
    if own.acceleration:
        step = own.fraction * robot.acceleration_limit * tick.dt
        for j in range(len(step)):
            anchor = min(max(tick.u_previous[j], lower[j]), upper[j])
            lower[j], upper[j] = anchor - step[j], anchor + step[j]
        narrow(program, lower, upper, True)
