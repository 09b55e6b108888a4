"""`SelectionRule`: the selector's settings."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.controller.guidance.guidance_config import GuidanceConfig
from remosplat_drake.controller.guidance.planner import (
    GuidancePlanner,
    Situation,
)
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.planning.plan import Plan
from remosplat_drake.controller.planning.roadmap import NO_ROADMAP, Roadmap
from remosplat_drake.controller.planning.timing import TimingLimits
from remosplat_drake.controller.program.guidance import DIRECT, Guidance
from remosplat_drake.controller.program.solvers import make_solver
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField

_TIME_ON_PATH = 4.0
"""For each radian or metre of a path, its rollout simulates at most this time
[s]."""

_RETREAT = 0.002
"""If the robot violates a stopping distance by at most this value, it keeps
that stopping distance and first retreats; otherwise, a smaller stopping
distance is used [m]."""


@dc.dataclass(frozen=True, eq=False)
class SelectionRule:
    """The selector's settings, which are the same at all ticks.

    Attributes:
        law: The control law of rollouts, whose period is the step of a rollout.
        planner: The planner that proposes the candidates.
        tiers: Stopping distances that may be used, largest first [m].
        arrived: Function that returns whether a `PoseError` counts as arrival.
            It may be called from several threads.
        horizon: Longest simulated time of a rollout [s].
        start: The initial guidance.
        motions: The planner of paths through configurations; None if no paths
            are searched.
    """

    law: ReactiveLaw
    planner: GuidancePlanner
    tiers: tuple[float, ...]
    arrived: Callable[[PoseError], bool]
    horizon: float
    start: Guidance = DIRECT
    motions: MotionPlanner | None = None

    def kept_tier(self, q: np.ndarray, field: DistanceField) -> int:
        """Returns the index of the largest stopping distance that holds at q.

        A robot that is nearer to an obstacle than its stopping distance must
        first retreat, away from a line or a path that keeps a smaller one.

        Args:
            q: The configuration, shape (n_q,) [rad, m].
            field: The map.

        Returns:
            The index in `tiers`; that of the smallest if none holds at q.
        """
        if len(self.tiers) == 1:
            return 0
        spheres = self.law.robot.spheres_at(q)
        least = field.clearances(spheres, self.tiers[0]).minimum() + _RETREAT
        kept = (i for i, tier in enumerate(self.tiers) if least >= tier)
        return next(kept, len(self.tiers) - 1)

    def from_tier(self, tier: int) -> "SelectionRule":
        """Returns the rule without the largest stopping distances.

        Args:
            tier: Index of the first stopping distance that remains.
        """
        if tier == 0:
            return self
        tiers = self.tiers[tier:]
        start = dc.replace(self.start, stopping=tiers[0])
        return dc.replace(self, tiers=tiers, start=start)

    def first(self, aim: Aim) -> Guidance:
        """Returns the guidance that the robot first follows to new targets.

        If a target has a line, the joint limit damper has the smaller stopping
        distances of planned paths. With its own stopping distances, it could
        push the end effector back along the line.

        Args:
            aim: The targets of the end effectors.
        """
        if self.motions is None or not aim.has_line:
            return self.start
        config = self.motions.config
        return dc.replace(
            self.start,
            name="line",
            joint_stop=config.joint_stop,
            slide_stop=config.slide_stop,
        )

    def holding(self, payload: Payload | None) -> "SelectionRule":
        """Returns the settings for the robot with another payload.

        Args:
            payload: The payload; None if the robot carries nothing.
        """
        law = self.law.holding(payload)
        if law is self.law:
            return self
        motions = self.motions
        if motions is not None:
            motions = dc.replace(
                motions, robot=law.robot, self_clearance=law.self_clearance
            )
        return dc.replace(self, law=law, motions=motions)

    def candidates(
        self, q: np.ndarray, aim: Aim, field: DistanceField
    ) -> tuple[tuple[Guidance, ...], ...]:
        """Returns the planner's candidates, a tuple for each tier.

        Args:
            q: Present configuration, shape (n_q,) [rad, m].
            aim: The targets of the end effectors.
            field: The map.
        """
        situation = Situation(self.law.robot, q, aim, field, self.tiers)
        return tuple(map(tuple, self.planner.propose(situation)))

    def planned(
        self,
        now: PresentState,
        field: DistanceField,
        tier: int,
        attempt: int,
        interrupted: Callable[[], bool] = lambda: False,
        roadmap: Roadmap = NO_ROADMAP,
        around: Movers | None = None,
    ) -> tuple[Guidance | None, Plan]:
        """Searches a path that keeps a tier's stopping distance.

        Args:
            now: The present state.
            field: The map.
            tier: Index of the tier.
            attempt: Number of earlier rounds with a search.
            interrupted: Function that returns whether to abort the search.
            roadmap: Corners of earlier paths, which are tried first.
            around: Standing movers. Paths keep the same distance from them as
                verification.

        Returns:
            The guidance along the path, or None if no path was found, and the
            result of the search.
        """
        assert self.motions is not None
        stopping = self.tiers[tier]
        plan = self.motions.plan(
            now.q,
            now.aim,
            field,
            stopping,
            attempt,
            interrupted,
            roadmap,
            around,
            self.law.movers.separation,
        )
        if plan.path is None:
            return None, plan
        guidance = Guidance(
            "plan",
            active_scale=0.0,
            stopping=stopping,
            approach_scale=self.motions.config.approach_scale,
            path=plan.path,
            joint_stop=self.motions.config.joint_stop,
            slide_stop=self.motions.config.slide_stop,
        )
        return guidance, plan

    def still_open(
        self, guidance: Guidance, q: np.ndarray, field: DistanceField
    ) -> Guidance:
        """Truncates a guidance's path before the first part that a map blocks.

        Args:
            guidance: The guidance, with or without a path.
            q: Present configuration, shape (n_q,) [rad, m].
            field: The map.

        Returns:
            The guidance; the same object if its path is not blocked.
        """
        path = guidance.path
        if path is None or self.motions is None:
            return guidance
        stopping = self.law.collision.stopping_for(guidance)
        still = self.motions.open_part(path, q, field, stopping)
        return guidance if still is path else dc.replace(guidance, path=still)

    def horizon_of(self, guidance: Guidance) -> float:
        """Returns the longest simulated time of a guidance's rollout [s].

        A rollout along a path may take longer than a rollout of the direct way.

        Args:
            guidance: The guidance.
        """
        if guidance.path is None:
            return self.horizon
        return self.horizon + _TIME_ON_PATH * guidance.path.length


def make_selection_rule(
    law: ReactiveLaw,
    config: GuidanceConfig,
    arrived: Callable[[PoseError], bool],
) -> SelectionRule:
    """Makes the selector's settings for a controller.

    Rollouts use the controller's law with all its ingredients, a longer period,
    and a solver that is faster for small programs. They include verification.
    So a rollout does not reach the target if verification would stop the robot.

    Args:
        law: The control law of the controller.
        config: Horizon and budget of the selector.
        arrived: Function that returns whether a `PoseError` counts as arrival.

    Raises:
        FieldError: The step or the solver of the rollouts is invalid.
    """
    solver = make_solver(config.solver, "scenario", "guidance.solver")
    tiers = law.collision.stopping, *config.tiers
    motions = None
    if config.planning.enabled:
        motions = MotionPlanner(
            law.robot,
            law.self_clearance,
            config.planning,
            TimingLimits(law.collision, config.planning.approach_scale, law.dt),
        )
    return SelectionRule(
        law.with_step(config.step, solver=solver),
        config.planner,
        tiers,
        arrived,
        config.horizon,
        Guidance(stopping=tiers[0]),
        motions,
    )
