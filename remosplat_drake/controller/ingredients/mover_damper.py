"""Mover damper: limits the approach to movers, and retreats from fast ones."""

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
from remosplat_drake.controller.program.kernels.tick_arrays import new_row
from remosplat_drake.robot.robot_arrays import add_rate
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.binding import MOVER


@dc.dataclass
class MoverDamperConfig(Config):
    """Settings of the damper that limits the approach to movers."""

    # Influence distance d_i; movers beyond it are ignored [m].
    influence: Annotated[float, Interval(gt=0, le=5)] = 0.8
    # Distance d_s that the robot keeps from possible positions of movers [m].
    separation: Annotated[float, Interval(ge=0, le=1)] = 0.05
    # Largest speed xi of approach at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 1.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the influence distance exceeds the separation.

        Yields:
            The name of a field that is invalid, and a description of the
            problem.
        """
        if not self.influence > self.separation:
            yield (
                "influence",
                f"must exceed the separation {self.separation},"
                f" got {self.influence}",
            )


class MoverDamper(CompiledIngredient):
    """A velocity damper for movers.

    `add_mover_damper` computes its rows.

    Attributes:
        config: Distances d_i and d_s, and the speed xi. Verification uses d_s,
            too.
    """

    term = MOVER

    def __init__(self, config: MoverDamperConfig):
        self.config = config

    def settings(self, robot: RobotModel) -> "MoverSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config = self.config
        return MoverSettings(config.influence, config.separation, config.gain)

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> tuple[str, str]:
        """Returns the names of a link and a mover; see `CompiledIngredient`."""
        assert movers is not None
        mover, sphere = divmod(int(number), len(robot.spheres))
        return robot.spheres.links[sphere], movers.movers[mover].name


class MoverSettings(NamedTuple):
    """Settings of a `MoverDamper` for kernels."""

    influence: float
    separation: float
    gain: float


@kernel(returns=NOTHING)
def add_mover_damper(own, k, tick, program):
    """Adds a velocity damper for movers.

    For each pair of a sphere and a mover whose distance d is within the
    influence distance d_i [m],

        n' Jv_WS u <= xi (d - d_s - tube) / (d_i - d_s) - c

    n is the direction from the sphere towards the mover in W, Jv_WS the
    Jacobian of the sphere's centre in W, xi the largest speed of approach at
    d_i [m/s], d_s the separation [m], and c the part of the approach speed that
    the mover's motion causes [m/s]. The tube is a bound of the sphere's
    deviation from its path [m]. If the right-hand side is negative, because the
    mover approaches fast, the robot must retreat. If the program is infeasible,
    these rows are relaxed first: they then demand only a part of the retreat,
    but still forbid any approach. Verification ensures that a moving robot does
    not touch the mover.

    d is the distance from all places that the mover can reach while the station
    executes one command. Verification uses the same distance for each moving
    sphere, so a sphere can move along the mover at this distance.

    See `CompiledIngredient` for the arguments.
    """
    robot, state, moving = tick.robot, tick.state, tick.moving
    n = len(robot.radius)
    for i in range(len(moving.sphere)):
        s = moving.sphere[i]
        margin = moving.distance[i] - own.separation - tick.tube[s]
        b = own.gain * margin / (own.influence - own.separation)
        about = moving.mover[i] * n + s
        row = new_row(program, k, b - moving.closing[i], about)
        body, p_WS = robot.body_S[s], state.p_WS[s]
        n_W = moving.direction_W[i]
        add_rate(robot, state, body, p_WS, n_W, 1.0, program.A[row])
