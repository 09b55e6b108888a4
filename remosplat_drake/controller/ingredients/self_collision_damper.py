"""Self-collision damper: limits the approach of two links of the robot."""

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
from remosplat_drake.controller.program.kernels.tick_arrays import (
    NearSettings,
    new_row,
)
from remosplat_drake.robot.robot_arrays import add_rate
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pairs import (
    self_collision_pairs,
)
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.binding import SELF_COLLISION

_CROWDED = 1.2
"""Distance of two links, as a fraction of the stopping distance, below which
each pair of their shapes has a separate row, since verification checks each
pair of shapes."""


@dc.dataclass
class SelfCollisionDamperConfig(Config):
    """Settings of the damper that limits the approach of two links."""

    # Whether self-collision is prevented.
    enabled: bool = True
    # Influence distance; pairs of links beyond it are ignored [m].
    influence: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Stopping distance between the shapes of two links [m].
    stopping: Annotated[float, Interval(ge=0, le=0.5)] = 0.01
    # Largest speed of approach at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 0.5

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


class SelfCollisionDamper(CompiledIngredient):
    """A velocity damper between links of the robot.

    `add_self_collision_damper` computes its rows.

    Args:
        config: Distances, and the largest speed of approach.
        robot: The robot, for its shapes and links.

    Attributes:
        config: The damper's settings. A `ReactiveLaw` also uses their distances
            for verification.
    """

    term = SELF_COLLISION

    def __init__(self, config: SelfCollisionDamperConfig, robot: RobotModel):
        self.config = config
        self._pairs = self_collision_pairs(robot, config.stopping)

    @property
    def near_settings(self) -> NearSettings:
        """The pairs and the reach, which are arguments of `near_arrays`.

        The reach is negative if the damper is disabled.
        """
        pairs, config = self._pairs, self.config
        reach = float(config.influence) if config.enabled else -1.0
        crowded = float(_CROWDED * config.stopping)
        return NearSettings(pairs.pair_arrays.values, reach, crowded)

    def settings(self, robot: RobotModel) -> "SelfCollisionSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config = self.config
        span = config.influence - config.stopping
        return SelfCollisionSettings(config.stopping, config.gain / span)

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> tuple[str, str]:
        """Returns the names of a pair's links; see `CompiledIngredient`."""
        return self._pairs.links(number)


class SelfCollisionSettings(NamedTuple):
    """Settings of a `SelfCollisionDamper` for kernels."""

    stopping: float
    slope: float


@kernel(returns=NOTHING)
def add_self_collision_damper(own, k, tick, program):
    """Adds a velocity damper between links of the robot.

    For each pair of points at which two links are nearer to each other than the
    influence distance d_i [m],

        n' (Jv_Wp - Jv_Wq) u <= gain (d - d_s) / (d_i - d_s)

    (Faverjon and Tournassoud 1987). p is on the first link and q on the
    second, Jv_Wp and Jv_Wq are their Jacobians in W, n is the unit normal from
    p to q in W, d their distance and d_s the stopping distance [m], and `gain`
    the largest speed of approach [m/s]. Two links have one row for their
    nearest points, and up to four more for points that would be the nearest
    after a small rotation.

    See `CompiledIngredient` for the arguments.
    """
    robot, state, near = tick.robot, tick.state, tick.near
    for i in range(len(near.pair)):
        b = own.slope * (near.distance[i] - own.stopping)
        row = program.A[new_row(program, k, b, near.pair[i])]
        n_W = near.normal_W[i]
        add_rate(robot, state, near.body_A[i], near.p_WA[i], n_W, 1.0, row)
        add_rate(robot, state, near.body_B[i], near.p_WB[i], n_W, -1.0, row)
