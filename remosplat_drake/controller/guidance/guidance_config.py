"""`GuidanceConfig`: horizon and budget of the selector."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.controller.guidance.planner import (
    GuidancePlanner,
    SidePlanner,
)
from remosplat_drake.controller.planning.planning_config import PlanningConfig
from remosplat_drake.controller.program.solvers import SOLVERS


@dc.dataclass
class GuidanceConfig(Config):
    """Settings of the selection of guidance by rollouts on the known map."""

    # Whether guidance is selected; otherwise the controller always drives
    # straight to the target.
    enabled: bool = True
    # Number of rollout steps in a control tick. Each takes about 0.2 ms with
    # ellipsoids, so 10 fit into a period of 10 ms. A tick that immediately
    # searches a path takes more steps, to compare the path with the direct way.
    # With 0, nothing is simulated: whenever the robot stalls, it follows the
    # next candidate.
    budget: Annotated[int, Interval(ge=0, le=10_000)] = 10
    # Whether a separate process computes the rollouts, so that ticks do not
    # wait for them, as real robots require. Runs then depend on the machine's
    # speed, and `budget_ms` replaces `budget`.
    asynchronous: bool = False
    # Time after which the process of `asynchronous` answers, ideally slightly
    # less than the control period [ms]. It then continues unfinished rollouts.
    budget_ms: Annotated[float, Interval(gt=0, le=1000)] = 8.0
    # Convex solver of the rollouts, with the same choices as that of the
    # controller.
    solver: Annotated[str, OneOf(SOLVERS, "solver")] = "active_set"
    # Duration of one step of a rollout [s].
    step: Annotated[float, Interval(gt=0, le=0.1)] = 0.1
    # Longest simulated time of a rollout [s].
    horizon: Annotated[float, Interval(gt=0, le=60)] = 8.0
    # Planner of the candidates: the library's, which proposes direct, left and
    # right, or another one as `package.module:Class`.
    planner: SidePlanner | GuidancePlanner = dc.field(
        default_factory=SidePlanner
    )
    # Search of paths if none of the planner's candidates arrives.
    planning: PlanningConfig = dc.field(default_factory=PlanningConfig)
    # Smaller stopping distances that may be tried if no candidate arrives with
    # the usual one, largest first [m]. They require a sufficiently accurate
    # map, according to `scene.map_error` or the quality report.
    tiers: Annotated[
        list[Annotated[float, Interval(gt=0, le=1)]], Len(0, 16)
    ] = dc.field(default_factory=list)

    @property
    def plans(self) -> bool:
        """Whether paths are planned."""
        simulates = self.asynchronous or self.budget > 0
        return self.enabled and simulates and self.planning.enabled

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the horizon exceeds the step of a rollout.

        Yields:
            The name of a field and what is wrong with it.
        """
        if not self.horizon > self.step:
            yield "horizon", f"must exceed the step, got {self.horizon}"
