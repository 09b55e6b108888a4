"""Defines planners, which propose the candidates of guidance."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Annotated, Protocol

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.guidance import (
    Guidance,
    make_candidates,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.target import Target


@dc.dataclass(frozen=True, eq=False)
class Situation:
    """The state from which a planner proposes candidates of guidance.

    Attributes:
        robot: The robot, with its limits and kinematics.
        q: The robot's present configuration, shape (n_q,) [rad, m].
        aim: The targets of the end effectors.
        field: The map in which rollouts are simulated.
        tiers: Stopping distances in the order in which they may be tried,
            largest first [m].
    """

    robot: RobotModel
    q: np.ndarray
    aim: Aim
    field: DistanceField
    tiers: tuple[float, ...]

    @property
    def target(self) -> Target:
        """The first target."""
        return self.aim.first

    @property
    def X_WT(self) -> np.ndarray:
        """Pose X_WT of the target in the world, shape (4, 4)."""
        return self.target.X_WT


class GuidancePlanner(Protocol):
    """Protocol of planners, such as `SidePlanner`, which propose candidates."""

    def propose(self, situation: Situation) -> Sequence[Sequence[Guidance]]:
        """Proposes the candidates of a round for each tier (stopping distance).

        A tier consists of the candidates with the same stopping distance. They
        are simulated in parallel, from the robot's state at the time at which
        the tier begins. They share the budget, so many candidates take longer.
        A smaller stopping distance is tried only if no candidate reaches the
        target with a larger one. Safety does not depend on candidates.

        Args:
            situation: Robot, targets, map, and the stopping distances that may
                be tried.

        Returns:
            The candidates of each tier, in the order of the tiers.
        """
        ...


@dc.dataclass
class SidePlanner(Config):
    """Proposes three candidates: go direct, or pass obstacles left or right."""

    # Angle by which the base is turned away from the direction to the end
    # effector, towards the chosen side [rad].
    bearing: Annotated[float, Interval(ge=-3.2, le=3.2)] = 0.8
    # Factor of the gain of the active collision cost while the robot passes an
    # obstacle on one side.
    active_scale: Annotated[float, Interval(ge=0, le=10)] = 0.5

    def propose(self, situation: Situation) -> Sequence[Sequence[Guidance]]:
        """Proposes the candidates `direct`, `left` and `right` for each tier.

        A tier consists of the candidates with the same stopping distance. The
        candidates `left` and `right` turn the base, so for a robot without a
        base only `direct` is proposed.

        Args:
            situation: The robot, and the stopping distances that may be tried.
                The other attributes are not used.
        """
        if not situation.robot.n_base:
            return [[Guidance("direct", stopping=t)] for t in situation.tiers]
        return make_candidates(situation.tiers, self.bearing, self.active_scale)
