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
    """How guidance is selected by rollouts on the known map."""

    # Whether guidance is selected; without it the controller goes straight.
    enabled: bool = True
    # Number of rollout steps that a control tick may spend. Each costs about
    # 0.2 ms with ellipsoids, and 10 leave room in a period of 10 ms. A tick
    # that searches a path at once spends more, to compare it. With 0 nothing is
    # simulated: whenever the robot stalls, the next candidate is tried.
    budget: Annotated[int, Interval(ge=0, le=10_000)] = 10
    # Whether a process of its own looks ahead, so that ticks do not wait for
    # it, as real robots need. Runs then depend on the machine, and
    # `budget_ms` counts in place of `budget`.
    asynchronous: bool = False
    # Time that the process of `asynchronous` takes for an answer, best a
    # little less than the control period [ms]. What it has not finished then,
    # it goes on with.
    budget_ms: Annotated[float, Interval(gt=0, le=1000)] = 8.0
    # Convex solver of the rollouts, with the same choices as that of the
    # controller.
    solver: Annotated[str, OneOf(SOLVERS, "solver")] = "active_set"
    # Time that one step of a rollout simulates [s].
    step: Annotated[float, Interval(gt=0, le=0.1)] = 0.1
    # Longest time that a rollout simulates [s].
    horizon: Annotated[float, Interval(gt=0, le=60)] = 8.0
    # What proposes the candidates: the library's, which are direct, left and
    # right, or one's own as `package.module:Class`.
    planner: SidePlanner | GuidancePlanner = dc.field(
        default_factory=SidePlanner
    )
    # How paths are searched where none of these candidates arrives.
    planning: PlanningConfig = dc.field(default_factory=PlanningConfig)
    # Smaller stopping distances that may be tried when nothing arrives with
    # the usual one, largest first [m]. They need a map that is accurate
    # enough, as `scene.map_error` or the quality report says.
    tiers: Annotated[
        list[Annotated[float, Interval(gt=0, le=1)]], Len(0, 16)
    ] = dc.field(default_factory=list)

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the horizon exceeds the step of a rollout.

        Yields:
            The name of a field and what is wrong with it.
        """
        if not self.horizon > self.step:
            yield "horizon", f"must exceed the step, got {self.horizon}"
