"""`GuidanceConfig`: how far and how much the selector looks ahead."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.controller.guidance.planner import (
    GuidancePlanner,
    SidePlanner,
)
from remosplat_drake.controller.solvers import SOLVERS


@dc.dataclass
class GuidanceConfig(Config):
    """Rollout-selected guidance; without it the controller is reactive."""

    # Whether guidance is selected at all.
    enabled: bool = True
    # Rollout steps that a control tick may spend; each costs about 0.6 ms
    # with ellipsoids, and 10 leave room in a period of 10 ms. With 0 nothing
    # is simulated: whenever the robot stalls, the next candidate is tried.
    budget: Annotated[int, Interval(ge=0, le=10_000)] = 10
    # Look ahead in a process of its own, so that ticks do not wait for it:
    # for real robots. Runs then depend on the machine, and `budget` is idle.
    asynchronous: bool = False
    # How long that process takes for an answer [ms], best a little less than
    # the control period; what it has not finished it goes on with.
    budget_ms: Annotated[float, Interval(gt=0, le=1000)] = 8.0
    # Convex solver of the rollouts; see controller/solvers.py.
    solver: Annotated[str, OneOf(SOLVERS, "solver")] = "active_set"
    # Time that one rollout step simulates [s].
    step: Annotated[float, Interval(gt=0, le=0.1)] = 0.1
    # Longest time that a rollout simulates [s].
    horizon: Annotated[float, Interval(gt=0, le=60)] = 8.0
    # What proposes the candidates: left and right, or one's own as
    # `package.module:Class`.
    planner: SidePlanner | GuidancePlanner = dc.field(
        default_factory=SidePlanner
    )
    # Smaller stopping distances that may be tried when nothing arrives with
    # the usual one, largest first [m]. Needs a map that is accurate enough:
    # scene.map_error.
    tiers: Annotated[
        list[Annotated[float, Interval(gt=0, le=1)]], Len(0, 16)
    ] = dc.field(default_factory=list)

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        if not self.horizon > self.step:
            yield "horizon", f"must exceed the step, got {self.horizon}"
