"""Prefer motions that gain clearance: the paper's active collision cost."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamperConfig,
)
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick


@dc.dataclass
class ActiveCollisionCostConfig(Config):
    """Settings of the cost that makes the robot leave obstacles."""

    # Gain g of the cost; 0 leaves the cost out. Guidance may scale it down.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.6


class ActiveCollisionCost:
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
        program.add_linear_cost("active collision", gain * nearness**2 * mean)
