"""A cost: turn the arm's first joint."""

import dataclasses as dc
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)


@dc.dataclass
class Drift(Config):
    """A linear cost that turns the arm's first joint."""

    # Negative turns it to the left.
    gain: Annotated[float, Interval(ge=-10, le=10)] = 1.0

    def AddToProgram(self, program, tick) -> None:
        """Adds the cost."""
        c = np.zeros(program.n_u)
        c[tick.robot.n_base] = self.gain
        program.add_linear_cost("drift", c)


class Gain(NamedTuple):
    """Settings of a `CompiledDrift`."""

    gain: float


@dc.dataclass
class CompiledDrift(Config, CompiledIngredient):
    """The same as one compiled function."""

    gain: Annotated[float, Interval(ge=-10, le=10)] = 1.0

    term = "drift"

    def settings(self, robot) -> Gain:
        """Makes what `add` takes."""
        return Gain(self.gain)

    @staticmethod
    def add(own, k, tick, program):
        """Adds the cost."""
        program.linear[k, tick.robot.n_base] += own.gain


@dc.dataclass
class DriftOf(Config):
    """Makes a `Drift` that suits the robot."""

    share: Annotated[float, Interval(ge=0, le=1)] = 0.5

    def make(self, robot) -> Drift:
        """Makes the ingredient."""
        return Drift(self.share * robot.n_u)
