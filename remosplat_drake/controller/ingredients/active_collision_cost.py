"""Prefer motions that gain clearance: the paper's active collision cost."""

import dataclasses as dc
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamperConfig,
)
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.tick_arrays import given_or
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class ActiveCollisionCostConfig(Config):
    """Settings of the cost that makes the robot leave obstacles."""

    # Gain g of the cost; 0 leaves the cost out. Guidance may scale it down.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.6


class ActiveCollisionCost(CompiledIngredient):
    """A linear cost on the approach to everything near (paper section IV-E).

    The cost is c'u with the weighted mean of the collision rows A_j,

        c = g ((d_min - d_i) / (d_i - d_s))^2 sum(w_j A_j) / sum(w_j),
        w_j = (d_i - d_j) / (d_i - d_s),

    for clearances d_j, the least of them d_min, the influence distance d_i and
    the stopping distance d_s. The gain that grows with nearness is that of
    RMMI (Marticorena et al. 2024).

    Args:
        config: Gain of the cost.
        damper: The collision damper's distances d_i and d_s.
    """

    term = "active collision"

    def __init__(
        self, config: ActiveCollisionCostConfig, damper: CollisionDamperConfig
    ):
        self._gain = config.gain
        self._damper = damper

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost, if anything is within the influence distance.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; its clearances and its guidance
                matter here.
        """
        clearances = tick.clearances
        gain = self._gain * tick.guidance.active_scale
        if gain == 0.0 or not len(clearances):
            return
        influence = self._damper.influence
        span = influence - self._damper.stopping_for(tick.guidance)
        w = (influence - clearances.distance) / span
        mean = w @ tick.approach_rates / w.sum()
        nearness = (influence - clearances.minimum()) / span
        program.add_linear_cost(self.term, gain * nearness**2 * mean)

    def settings(self, robot: RobotModel) -> "ActiveCollisionSettings":
        """Makes what the kernel takes; see `CompiledIngredient`."""
        damper = self._damper
        return ActiveCollisionSettings(
            self._gain, damper.influence, damper.stopping
        )


class ActiveCollisionSettings(NamedTuple):
    """Settings of the ActiveCollisionCost, for kernels."""

    gain: float
    influence: float
    stopping: float


@helper
def add_active_collision_cost(own, k, tick, program):
    """Adds an `ActiveCollisionCost`; see `kernels/assemble.py`."""
    gain = own.gain * tick.guidance.active_scale
    if gain == 0.0 or not len(tick.distance):
        return
    span = own.influence - given_or(tick.guidance.stopping, own.stopping)
    c, total, least = program.linear[k], 0.0, np.inf
    for i in range(len(tick.distance)):
        w = (own.influence - tick.distance[i]) / span
        total += w
        least = min(least, tick.distance[i])
        for j in range(len(c)):
            c[j] += w * tick.rates[i, j]
    nearness = (own.influence - least) / span
    c *= gain * nearness**2 / total
    program.has[k, 0] = True
