"""Slow down before the scene: the paper's hard collision constraint."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick

NAME = "collision"


@dc.dataclass
class CollisionDamperConfig(Config):
    """How close the robot may come, and how fast."""

    # Distance d_i within which the scene matters [m].
    influence: Annotated[float, Interval(gt=0, le=5)] = 0.5
    # Distance d_s that is kept [m].
    stopping: Annotated[float, Interval(ge=0, le=1)] = 0.021
    # Largest approach speed xi at the influence distance [m/s].
    gain: Annotated[float, Interval(gt=0, le=10)] = 1.0

    def stopping_for(self, guidance: Guidance) -> float:
        """The stopping distance of a tick with that guidance [m]."""
        if guidance.stopping is None:
            return self.stopping
        return guidance.stopping

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        if not self.influence > self.stopping:
            yield (
                "influence",
                f"must exceed the stopping distance {self.stopping},"
                f" got {self.influence}",
            )


class CollisionDamper:
    """n' Jv_WS u <= xi (d - d_s) / (d_i - d_s) (paper section IV-D).

    Attributes:
        config: Its distances; verification and the oracle's queries of a
            `ReactiveLaw` go by them, too.
    """

    def __init__(self, config: CollisionDamperConfig):
        self.config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds a row for every clearance within the influence distance."""
        config, clearances = self.config, tick.clearances
        if not len(clearances):
            return
        stopping = config.stopping_for(tick.guidance)
        margin = clearances.distance - stopping
        b = config.gain * margin / (config.influence - stopping)

        def label(i: int) -> str:
            sphere = clearances.sphere[i]
            return f"sphere {sphere} on {tick.robot.spheres.links[sphere]}"

        program.add_rows(NAME, tick.approach_rates, b, label)
