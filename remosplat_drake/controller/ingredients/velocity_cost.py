"""Move little: a quadratic price on the command."""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick


@dc.dataclass
class VelocityCostConfig(Config):
    """The price of motion."""

    # Weight lambda of the squared rates.
    weight: Annotated[float, Interval(gt=0, le=100)] = 0.03


class VelocityCost:
    """lambda/2 |u_arm|^2 + lambda/(2 e) |u_base|^2.

    Far from the target the base is cheap; close to it the arm does the work
    (Haviland's holistic controller, paper section III-A).
    """

    def __init__(self, config: VelocityCostConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost."""
        weights = np.full(program.n_u, self._config.weight)
        weights[: tick.robot.n_base] /= tick.error_scale
        program.add_quadratic_cost("velocity", weights)
