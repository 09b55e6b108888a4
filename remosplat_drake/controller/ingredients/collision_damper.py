"""Collision damper: the paper's constraint that limits the approach speed."""

import dataclasses as dc
import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from annotated_types import Interval

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.program.kernels.tick_arrays import (
    given_or,
    new_row,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.binding import COLLISION

_LAST_MARGIN, _LAST_SLOPE = 0.005, 2.1
"""Range of clearances above the stopping distance in which the slope of the
damper's law is limited [m], and the largest slope in this range [1/s]."""

_SUDDEN = 0.9
"""Fraction of the greatest deceleration that a row may demand if the slope of
the damper's law exceeds `_LAST_SLOPE`."""


@dc.dataclass
class CollisionDamperConfig(Config):
    """Settings of the damper that limits the approach to the scene."""

    # Influence distance d_i; obstacles beyond it are ignored [m].
    influence: Annotated[float, Interval(gt=0, le=5)] = 0.5
    # Stopping distance d_s, which the robot keeps from the scene [m].
    stopping: Annotated[float, Interval(ge=0, le=1)] = 0.021
    # Largest speed xi of approach at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 2.0

    def stopping_for(self, guidance: Guidance) -> float:
        """Returns the stopping distance d_s of a tick [m].

        Args:
            guidance: The guidance, which may contain another stopping distance.
        """
        if guidance.stopping is None:
            return self.stopping
        return guidance.stopping

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the influence distance exceeds the stopping distance.

        Yields:
            The name of a field that is invalid, and a description of the
            problem.
        """
        if not self.influence > self.stopping:
            yield (
                "influence",
                f"must exceed the stopping distance {self.stopping},"
                f" got {self.influence}",
            )


class CollisionDamper(CompiledIngredient):
    """The collision constraint: a velocity damper for the scene.

    `add_collision_damper` computes its rows.

    Attributes:
        config: Distances d_i and d_s, and the speed xi. A `ReactiveLaw` also
            uses these distances for verification and for queries of the
            distance oracle.
    """

    term = COLLISION

    def __init__(self, config: CollisionDamperConfig):
        self.config = config

    def settings(self, robot: RobotModel) -> "CollisionSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config = self.config
        return CollisionSettings(config.influence, config.stopping, config.gain)

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> str:
        """Returns a sphere's name with its link; see `CompiledIngredient`."""
        return f"sphere {number} on {robot.spheres.links[number]}"


class CollisionSettings(NamedTuple):
    """Settings of a `CollisionDamper` for kernels."""

    influence: float
    stopping: float
    gain: float


@helper
def approach_speed(own, scale, stopping, margin):
    """Computes the greatest speed of approach that the damper permits [m/s].

    Args:
        own: The `CollisionSettings`, or a `CollisionDamperConfig`.
        scale: Factor of the gain.
        stopping: The stopping distance d_s [m].
        margin: Clearance minus d_s and minus the tube [m].
    """
    return scale * own.gain * margin / (own.influence - stopping)


@kernel(returns=NOTHING)
def add_collision_damper(own, k, tick, program):
    """Adds a velocity damper for the scene: one row for each clearance.

    For each clearance d within the influence distance d_i [m],

        n' Jv_WS u <= xi (d - d_s - tube) / (d_i - d_s)

    (paper section IV-D; Faverjon and Tournassoud 1987). n is the direction from
    the sphere towards the scene in W, Jv_WS the Jacobian of the sphere's centre
    in W, and xi the largest speed of approach [m/s]. A sphere nearer than the
    stopping distance d_s [m] must move away. In one control period, a sphere
    may approach by at most the remaining distance to d_s. Guidance may set d_s
    and scale xi.

    If d exceeds d_s by less than `_LAST_MARGIN`, the slope of this law over d
    is at most `_LAST_SLOPE`. With a steeper law, a sphere that slides along an
    obstacle would soon be at its stopping distance. There, the curvature of its
    path alone would bring it nearer, and verification would reject every
    command. In addition, a steep law limits the approach speed to sqrt(a (d -
    d_s)), where a is the sphere's greatest deceleration within the acceleration
    limits. Half of a is sufficient to stop from this speed. These two limits do
    not apply on a planned path, which keeps away from obstacles and slows down
    early. Finally, no row of a steep law demands a deceleration beyond the
    acceleration limits, since no command could satisfy it. Verification still
    rejects commands that are not safe.

    The tube is a bound of the deviation of a sphere from its path [m], which is
    zero for a robot without delay. Verification subtracts the tube, too. If
    this law did not, the program could command a motion along an obstacle that
    verification rejects.

    See `CompiledIngredient` for the arguments.
    """
    stopping = given_or(tick.guidance.stopping, own.stopping)
    scale = tick.guidance.approach_scale
    slope = approach_speed(own, scale, stopping, 1.0)
    excess = max(slope - _LAST_SLOPE, 0.0)
    if len(tick.guidance.path_s):
        excess = 0.0
    for i in range(len(tick.sphere)):
        margin = tick.distance[i] - stopping - tick.tube[tick.sphere[i]]
        b = slope * margin - excess * min(margin, _LAST_MARGIN)
        b = min(b, max(margin, 0.0) / tick.dt)
        if slope > _LAST_SLOPE and margin > 0.0:
            braking, approach = 0.0, 0.0
            for j in range(len(tick.u_previous)):
                limit = tick.robot.acceleration_limit[j]
                braking += abs(tick.rates[i, j]) * limit
                approach += tick.rates[i, j] * tick.u_previous[j]
            if excess > 0.0:
                b = min(b, math.sqrt(braking * margin))
            b = max(b, approach - _SUDDEN * braking * tick.dt)
        row = new_row(program, k, b, tick.sphere[i])
        moves = False
        for j in range(len(tick.u_previous)):
            program.A[row, j] = tick.rates[i, j]
            moves |= tick.rates[i, j] != 0.0
        if not moves:
            program.b[row] = max(b, 0.0)
