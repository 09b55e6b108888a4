"""Slow down before the scene: the paper's hard collision constraint."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated, NamedTuple

from annotated_types import Interval

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.tick_arrays import given_or, new_row
from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.tick import Tick
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

    For every clearance d within the influence distance d_i, with n the
    direction towards the scene and Jv_WS the sphere's Jacobian,

        n' Jv_WS u <= xi (d - d_s) / (d_i - d_s)

    (paper section IV-D; Faverjon and Tournassoud 1987). A sphere nearer than
    the stopping distance d_s must recede. Where a sphere may be off its path,
    its tube counts to d_s, as it does in verification: a robot that slides
    along an obstacle would else be told to slide where it is not let.

    Attributes:
        config: Distances d_i and d_s, and the speed xi. Verification and the
            oracle's queries of a `ReactiveLaw` go by these distances, too.
    """

    term = COLLISION

    def __init__(self, config: CollisionDamperConfig):
        self.config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds a row for every clearance within the influence distance.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; its clearances and its guidance
                matter here.
        """
        config, clearances = self.config, tick.clearances
        if not len(clearances):
            return
        stopping = config.stopping_for(tick.guidance)
        margin = clearances.distance - stopping
        if tick.sphere_tube is not None:
            margin = margin - tick.sphere_tube[clearances.sphere]
        b = config.gain * margin / (config.influence - stopping)

        def label(i: int) -> str:
            return self.about(tick.robot, None, clearances.sphere[i])

        program.add_rows(self.term, tick.approach_rates, b, label)

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


@helper
def add_collision_damper(own, k, tick, program):
    """Adds a `CollisionDamper`; see `kernels/assemble.py`."""
    stopping = given_or(tick.guidance.stopping, own.stopping)
    for i in range(len(tick.sphere)):
        margin = tick.distance[i] - stopping - tick.tube[tick.sphere[i]]
        b = own.gain * margin / (own.influence - stopping)
        row = new_row(program, k, b, tick.sphere[i])
        for j in range(len(tick.u_previous)):
            program.A[row, j] = tick.rates[i, j]
