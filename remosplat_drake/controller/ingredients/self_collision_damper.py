"""Slow down before the robot touches itself."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision import self_collision_pairs
from remosplat_drake.signals.binding import SELF_COLLISION


@dc.dataclass
class SelfCollisionDamperConfig(Config):
    """How close two parts of the robot may come, and how fast."""

    # Whether the robot is kept from touching itself.
    enabled: bool = True
    # Influence distance: spheres farther apart than this do not matter [m].
    influence: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Stopping distance, which spheres of two links keep from each other [m].
    stopping: Annotated[float, Interval(ge=0, le=0.5)] = 0.01
    # Largest speed of approach at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 0.5

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


class SelfCollisionDamper:
    """A velocity damper between the robot's own links.

    The damper of Faverjon and Tournassoud (1987) gets one row for each pair
    of links, that of their nearest pair of spheres, and one for each pair of
    spheres that is nearer at home than the stopping distance.

    Args:
        config: Distances of the damper, and its speed of approach.
        robot: The robot, for its spheres and links.

    Attributes:
        config: The damper's settings; verification of a `ReactiveLaw` goes
            by their distances, too.
    """

    def __init__(self, config: SelfCollisionDamperConfig, robot: RobotModel):
        self.config = config
        self._pairs = self_collision_pairs(robot, config.stopping)

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the rows of link pairs within the influence distance.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the robot's spheres and their
                Jacobians matter here.
        """
        config, spheres = self.config, tick.state.spheres
        if not (config.enabled and len(self._pairs.first)):
            return
        near = self._pairs.nearest(spheres, config.influence)
        if not len(near.first):
            return
        Jv_WS = tick.state.Jv_WS
        relative = Jv_WS[near.first] - Jv_WS[near.second]
        A = np.matvec(np.swapaxes(relative, 1, 2), near.direction_W)
        span = config.influence - config.stopping
        b = config.gain * (near.distance - config.stopping) / span
        links = tick.robot.spheres.links

        def label(i: int) -> tuple[str, ...]:
            return links[near.first[i]], links[near.second[i]]

        program.add_rows(SELF_COLLISION, A, b, label)
