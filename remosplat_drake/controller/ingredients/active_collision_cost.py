"""Active collision cost of the paper: prefers motions that gain clearance."""

import dataclasses as dc
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamperConfig,
)
from remosplat_drake.controller.ingredients.mover_damper import (
    MoverDamperConfig,
)
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.kernels.tick_arrays import given_or
from remosplat_drake.robot.robot_arrays import add_rate
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class ActiveCollisionCostConfig(Config):
    """Settings of the cost that makes the robot move away from obstacles."""

    # Gain g of the cost; 0 omits the cost. Guidance may reduce it.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.6
    # Look-ahead time for movers [s].
    lead: Annotated[float, Interval(ge=0, le=5)] = 0.5


class ActiveCollisionCost(CompiledIngredient):
    """A linear cost on the approach to near obstacles (paper section IV-E).

    `add_active_collision_cost` computes it.

    Args:
        config: Gain of the cost, and its look-ahead time.
        damper: Settings of the collision damper, with the distances d_i and
            d_s.
        movers: Settings of the damper for movers; None for its default values.
    """

    term = "active collision"

    def __init__(
        self,
        config: ActiveCollisionCostConfig,
        damper: CollisionDamperConfig,
        movers: MoverDamperConfig | None = None,
    ):
        self._gain, self._lead = config.gain, config.lead
        self._damper = damper
        self._movers = movers or MoverDamperConfig()

    def settings(self, robot: RobotModel) -> "ActiveCollisionSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        damper, movers = self._damper, self._movers
        return ActiveCollisionSettings(
            self._gain,
            damper.influence,
            damper.stopping,
            self._lead,
            movers.influence,
            movers.separation,
        )


class ActiveCollisionSettings(NamedTuple):
    """Settings of an `ActiveCollisionCost` for kernels."""

    gain: float
    influence: float
    stopping: float
    lead: float
    mover_influence: float
    mover_separation: float


@kernel(returns=NOTHING)
def add_active_collision_cost(own, k, tick, program):
    """Adds a linear cost on the approach to near obstacles.

    The cost is c'u (paper section IV-E), where c is a gain times the weighted
    mean of the collision rows A_j = n_j' Jv_WS_j, with n_j in W:

        c = g max(w_j)^2 sum(w_j A_j) / sum(w_j),
        w_j = (d_i - d_j) / (d_i - d_s)

    Here, d_j are the clearances, d_i is the influence distance, and d_s the
    stopping distance [m]. The weight w_j is 0 at d_i and 1 at d_s. RMMI
    (Marticorena et al. 2024) also uses a gain that increases with proximity.
    Guidance may reduce g and set d_s.

    Movers are included in the same way, at their predicted positions after the
    time `lead`, with the d_i and d_s of the mover damper. So the robot starts
    early to move out of their way.

    See `CompiledIngredient` for the arguments.
    """
    gain, soon = own.gain * tick.guidance.active_scale, tick.soon
    if gain == 0.0 or len(tick.distance) + len(soon.sphere) == 0:
        return
    span = own.influence - given_or(tick.guidance.stopping, own.stopping)
    c, total, least = program.linear[k], 0.0, np.inf
    for i in range(len(tick.distance)):
        w = (own.influence - tick.distance[i]) / span
        total += w
        least = min(least, tick.distance[i])
        for j in range(len(c)):
            c[j] += w * tick.rates[i, j]
    nearness = max((own.influence - least) / span, 0.0)
    mover_span = own.mover_influence - own.mover_separation
    robot, state = tick.robot, tick.state
    for i in range(len(soon.sphere)):
        w, s = (
            (own.mover_influence - soon.distance[i]) / mover_span,
            soon.sphere[i],
        )
        total += w
        nearness = max(nearness, w)
        body, p_WS = robot.body_S[s], state.p_WS[s]
        add_rate(robot, state, body, p_WS, soon.direction_W[i], w, c)
    c *= gain * nearness**2 / total
    program.has[k, 0] = True
