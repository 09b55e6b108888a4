"""`SelectionRule`: what the selector tries and when it counts as arrival."""

import dataclasses as dc
from collections.abc import Callable

from remosplat_drake.controller.guidance.guidance import (
    Guidance,
    make_candidates,
)
from remosplat_drake.controller.guidance.guidance_config import GuidanceConfig
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.solvers import make_solver
from remosplat_drake.robot.pose_error import PoseError


@dc.dataclass(frozen=True, eq=False)
class SelectionRule:
    """What stays the same from tick to tick.

    Attributes:
        law: The control law of rollouts: their step is its period.
        candidates: See `make_candidates`; the first tier's first one is
            where a task starts.
        arrived: Whether a pose error counts as arrival.
        horizon: Longest simulated time of a rollout [s].
    """

    law: ReactiveLaw
    candidates: tuple[tuple[Guidance, ...], ...]
    arrived: Callable[[PoseError], bool]
    horizon: float


def make_selection_rule(
    law: ReactiveLaw,
    config: GuidanceConfig,
    arrived: Callable[[PoseError], bool],
) -> SelectionRule:
    """The selector's rule beside a controller.

    Rollouts run the controller's own law, with all its ingredients, at a
    longer step and with a solver that is quicker with small programs.
    Verification is part of it: a future that it would stop must not count as
    arrival.

    Args:
        law: The controller's.
        config: How far and how much the selector looks ahead.
        arrived: Whether a pose error counts as arrival.

    Raises:
        FieldError: The rollouts' step or solver is unusable.
    """
    solver = make_solver(config.solver, "scenario", "guidance.solver")
    candidates = make_candidates(
        [law.collision.stopping, *config.tiers],
        config.bearing,
        config.active_scale,
    )
    return SelectionRule(
        law.with_step(config.step, solver=solver),
        candidates,
        arrived,
        config.horizon,
    )
