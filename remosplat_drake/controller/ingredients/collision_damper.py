"""Slow down before the scene: the paper's hard collision constraint."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from annotated_types import Interval

from remosplat_drake.base.kernels import kernel
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


@dc.dataclass
class CollisionDamperConfig(Config):
    """How close to the scene the robot may come, and how fast."""

    # Influence distance d_i: farther away the scene does not matter [m].
    influence: Annotated[float, Interval(gt=0, le=5)] = 0.5
    # Stopping distance d_s, which the robot keeps from the scene [m].
    stopping: Annotated[float, Interval(ge=0, le=1)] = 0.021
    # Largest speed xi of approach at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 1.0

    def stopping_for(self, guidance: Guidance) -> float:
        """Returns the stopping distance d_s of a tick [m].

        Args:
            guidance: How the tick is bent; it may come with a stopping
                distance of its own.
        """
        if guidance.stopping is None:
            return self.stopping
        return guidance.stopping

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the influence distance exceeds the stopping distance.

        Yields:
            The name of a field and what is wrong with it.
        """
        if not self.influence > self.stopping:
            yield (
                "influence",
                f"must exceed the stopping distance {self.stopping},"
                f" got {self.influence}",
            )


class CollisionDamper(CompiledIngredient):
    """The collision constraint: a velocity damper before the scene.

    `add_collision_damper` computes its rows.

    Attributes:
        config: Distances d_i and d_s, and the speed xi. Verification and the
            oracle's queries of a `ReactiveLaw` go by these distances, too.
    """

    term = COLLISION

    def __init__(self, config: CollisionDamperConfig):
        self.config = config

    def settings(self, robot: RobotModel) -> "CollisionSettings":
        """Makes what the kernel takes; see `CompiledIngredient`."""
        config = self.config
        return CollisionSettings(config.influence, config.stopping, config.gain)

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> str:
        """Names a sphere and its link; see `CompiledIngredient`."""
        return f"sphere {number} on {robot.spheres.links[number]}"


class CollisionSettings(NamedTuple):
    """Settings of the CollisionDamper, for kernels."""

    influence: float
    stopping: float
    gain: float


@kernel(returns=NOTHING)
def add_collision_damper(own, k, tick, program):
    """Adds a velocity damper before the scene: a row for every clearance.

    For every clearance d within the influence distance d_i [m],

        n' Jv_WS u <= xi (d - d_s - tube) / (d_i - d_s)

    (paper section IV-D; Faverjon and Tournassoud 1987). n is the direction
    from the sphere towards the scene in W, Jv_WS the Jacobian of the sphere's
    centre in W, and xi the largest speed of approach [m/s]. A sphere nearer
    than the stopping distance d_s [m] must recede. Guidance may set d_s.

    A sphere may be off its path by its tube [m], which is zero for a robot
    that obeys at once. Verification subtracts it, too: without it here, the
    program could command a slide along an obstacle that verification rejects.

    See `CompiledIngredient` for the arguments.
    """
    stopping = given_or(tick.guidance.stopping, own.stopping)
    for i in range(len(tick.sphere)):
        margin = tick.distance[i] - stopping - tick.tube[tick.sphere[i]]
        b = own.gain * margin / (own.influence - stopping)
        row = new_row(program, k, b, tick.sphere[i])
        moves = False
        for j in range(len(tick.u_previous)):
            program.A[row, j] = tick.rates[i, j]
            moves |= tick.rates[i, j] != 0.0
        if not moves:
            program.b[row] = max(b, 0.0)
