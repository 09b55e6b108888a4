"""Velocity cost: a quadratic cost on the command."""

import dataclasses as dc
from typing import Annotated, NamedTuple

from annotated_types import Interval

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.robot.robot_model import RobotModel

FAR = 100.0
"""Error e that is used if the aim contains a configuration, which the base must
reach [m]. It is large, so that the cost does not slow down the base on its
path."""


@dc.dataclass
class VelocityCostConfig(Config):
    """Settings of the quadratic cost of the command."""

    # Weight lambda of the squared velocities.
    weight: Annotated[float, Interval(gt=0, le=100)] = 0.03


class VelocityCost(CompiledIngredient):
    """A quadratic cost of the command, which `add_velocity_cost` computes.

    Args:
        config: Weight lambda of the cost.
    """

    term = "velocity"

    def __init__(self, config: VelocityCostConfig):
        self._config = config

    def settings(self, robot: RobotModel) -> "VelocityCostSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        return VelocityCostSettings(self._config.weight)


class VelocityCostSettings(NamedTuple):
    """Settings of a `VelocityCost` for kernels."""

    weight: float


@kernel(returns=NOTHING)
def add_velocity_cost(own, k, tick, program):
    """Adds a quadratic cost of the command.

    The cost is

        lambda/2 |u_arm|^2 + lambda/(2 e) |u_base|^2

    (paper section III-A; holistic controller of Haviland, Sünderhauf and Corke
    2022). e is the error to the target [m], or the largest error if there are
    several targets; see `servo.error_scale`. Far from the target, motion of the
    base has a low cost; near the target, mainly the arm moves. If the aim
    contains a configuration, the base must reach it, and e is `FAR`.

    See `CompiledIngredient` for the arguments.
    """
    program.has[k, 1] = True
    error = FAR if tick.aim.by_path else tick.error_scale
    for j in range(len(tick.u_previous)):
        on_base = j < tick.robot.n_base
        scale = error if on_base else 1.0
        program.quadratic[k, j] = own.weight / scale
