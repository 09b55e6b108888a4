"""`SelectionRule`: what the selector tries and when it counts as arrival."""

import dataclasses as dc
from collections.abc import Callable

from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.guidance.guidance import (
    Guidance,
    make_candidates,
)
from remosplat_drake.controller.tick import ReactiveLaw
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel


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
    config: ReactiveControllerConfig,
    robot: RobotModel,
    arrived: Callable[[PoseError], bool],
) -> SelectionRule:
    """The selector's rule for a controller configuration.

    Rollouts run the controller's own law with a longer step, and a solver
    that is quicker with small programs. Verification is part of it: a future
    that it would stop must not count as arrival.
    """
    guidance = config.guidance
    law = ReactiveLaw.make(
        dc.replace(config, solver=guidance.solver), robot, guidance.step
    )
    candidates = make_candidates(
        [config.collision.stopping, *guidance.tiers],
        guidance.bearing,
        guidance.active_scale,
    )
    return SelectionRule(law, candidates, arrived, guidance.horizon)
