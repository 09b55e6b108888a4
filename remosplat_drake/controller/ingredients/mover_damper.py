"""Slow down before what moves, and retreat from what comes too fast."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick
from remosplat_drake.signals.binding import MOVER


@dc.dataclass
class MoverDamperConfig(Config):
    """How close to things that move the robot may come, and how fast."""

    # Influence distance d_i: farther away a mover does not matter [m].
    influence: Annotated[float, Interval(gt=0, le=5)] = 0.8
    # Distance d_s that the robot keeps from where movers can be [m].
    separation: Annotated[float, Interval(ge=0, le=1)] = 0.05
    # Largest speed xi of approach at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 1.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the influence distance exceeds the separation.

        Yields:
            The name of a field and what is wrong with it.
        """
        if not self.influence > self.separation:
            yield (
                "influence",
                f"must exceed the separation {self.separation},"
                f" got {self.influence}",
            )


class MoverDamper:
    """A velocity damper before what moves.

    For every sphere and mover whose distance d is within the influence
    distance d_i, with n the direction towards the mover, Jv_WS the sphere's
    Jacobian and c the speed at which the mover comes nearer by itself,

        n' Jv_WS u <= xi (d - d_s) / (d_i - d_s) - c

    Where it comes faster than that allows, the robot must retreat. Should it
    not be able to, this is the first that it need not: then it only does not
    approach. What is touched is up to verification.

    Attributes:
        config: Distances d_i and d_s, and the speed xi. Verification keeps
            d_s, too.
    """

    term = MOVER

    def __init__(self, config: MoverDamperConfig):
        self.config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds a row for every sphere and mover near each other.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; what moves matters here.
        """
        near = tick.near_movers
        if near is None or not len(near):
            return
        config, links = self.config, tick.robot.spheres.links
        A = np.einsum(
            "mi,mij->mj", near.direction_W, tick.state.Jv_WS[near.sphere]
        )
        margin = near.distance - config.separation
        if tick.sphere_tube is not None:
            margin = margin - tick.sphere_tube[near.sphere]
        b = config.gain * margin / (config.influence - config.separation)

        def label(i: int) -> tuple[str, str]:
            return links[near.sphere[i]], near.names[i]

        program.add_rows(self.term, A, b - near.closing, label)
