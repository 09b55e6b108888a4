"""Move little: a quadratic price on the command."""

import dataclasses as dc
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
class VelocityCostConfig(Config):
    """Settings of the cost of motion."""

    # Weight lambda of the squared velocities.
    weight: Annotated[float, Interval(gt=0, le=100)] = 0.03


class VelocityCost(CompiledIngredient):
    """The quadratic cost lambda/2 |u_arm|^2 + lambda/(2 e) |u_base|^2.

    With e the distance to the target, the base is cheap far from it, and
    close to it the arm does the work (paper section III-A; holistic
    controller of Haviland, Sünderhauf and Corke 2022).

    Args:
        config: Weight lambda of the cost.
    """

    term = "velocity"

    def __init__(self, config: VelocityCostConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost of the squared command.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the pose error matters here.
        """
        weights = np.full(program.n_u, self._config.weight)
        weights[: tick.robot.n_base] /= tick.error_scale
        program.add_quadratic_cost(self.term, weights)

    def settings(self, robot: RobotModel) -> "VelocityCostSettings":
        """Makes what the kernel takes; see `CompiledIngredient`."""
        return VelocityCostSettings(self._config.weight)


class VelocityCostSettings(NamedTuple):
    """Settings of the VelocityCost, for kernels."""

    weight: float


@helper
def add_velocity_cost(own, k, tick, program):
    """Adds a `VelocityCost`; see `kernels/assemble.py`."""
    program.has[k, 1] = True
    for j in range(len(tick.u_previous)):
        on_base = j < tick.robot.n_base
        scale = tick.error_scale if on_base else 1.0
        program.quadratic[k, j] = own.weight / scale
