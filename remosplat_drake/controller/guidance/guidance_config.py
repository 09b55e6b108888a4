"""`GuidanceConfig`: settings of guidance, such as horizon and budget."""

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
    """Settings for the selection of guidance by rollouts on the known map."""

    # Whether guidance is selected. If not, the controller always moves the end
    # effector straight to the target.
    enabled: bool = True
    # Number of rollout steps in a control tick. A step takes about 0.2 ms on a
    # map of ellipsoids, so 10 steps fit into a period of 10 ms. If a path is
    # searched as soon as a target is given, the tick takes more steps to
    # compare the path with the direct way. With 0, nothing is simulated, and a
    # robot that stalls follows the next candidate.
    budget: Annotated[int, Interval(ge=0, le=10_000)] = 10
    # Whether a separate process computes the rollouts, so that ticks do not
    # wait for them. Real robots require this. The results then depend on the
    # speed of the computer, and `budget_ms` replaces `budget`.
    asynchronous: bool = False
    # Time after which the separate process sends its results [ms], ideally
    # slightly less than the control period. It then continues rollouts that
    # have not ended.
    budget_ms: Annotated[float, Interval(gt=0, le=1000)] = 8.0
    # Convex solver of the rollouts; its values are those of `solver` of the
    # controller.
    solver: Annotated[str, OneOf(SOLVERS, "solver")] = "active_set"
    # Duration of one step of a rollout [s].
    step: Annotated[float, Interval(gt=0, le=0.1)] = 0.1
    # Longest simulated time of a rollout [s].
    horizon: Annotated[float, Interval(gt=0, le=60)] = 8.0
    # Planner that proposes candidates: the library's `SidePlanner`, which
    # proposes direct, left and right, or another class as
    # `package.module:Class`.
    planner: SidePlanner | GuidancePlanner = dc.field(
        default_factory=SidePlanner
    )
    # Settings of the search for paths if none of the planner's candidates
    # reaches the target.
    planning: PlanningConfig = dc.field(default_factory=PlanningConfig)
    # Smaller stopping distances, the largest first [m]. They are tried if no
    # candidate reaches the target with the stopping distance of `collision`.
    # They require a map that is accurate enough, according to `scene.map_error`
    # or the quality report.
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
            The name of a field that is invalid, and a description of the
            problem.
        """
        if not self.horizon > self.step:
            yield "horizon", f"must exceed the step, got {self.horizon}"
