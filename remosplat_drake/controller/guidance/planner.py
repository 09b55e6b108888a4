"""Planners: they propose the guidances among which the selector chooses."""

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
    """The inputs of a planner when the present guidance does not arrive.

    Attributes:
        robot: The robot, with its limits and kinematics.
        q: The robot's present configuration, shape (n_q,) [rad, m].
        aim: The targets of the end effectors.
        field: The map of rollouts.
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
        """The target, the first of several."""
        return self.aim.first

    @property
    def X_WT(self) -> np.ndarray:
        """Pose of that target T in the world W, shape (4, 4)."""
        return self.target.X_WT


class GuidancePlanner(Protocol):
    """Proposes guidances that may be tried: `SidePlanner`, or one's own."""

    def propose(self, situation: Situation) -> Sequence[Sequence[Guidance]]:
        """Proposes the candidates of a round of selection, tier after tier.

        The candidates of a tier are rolled out side by side from where the
        robot is when their turn comes, and share the budget, so that many of
        them take long. The next tier is tried if none of those before arrives.
        Safety does not rest on them.

        Args:
            situation: Robot, target, map and the stopping distances that may
                be tried.

        Returns:
            The candidates of each tier, in the order of the tiers.
        """
        ...


@dc.dataclass
class SidePlanner(Config):
    """Proposes to go direct, left and right at every stopping distance."""

    # Angle by which the base turns from the end effector towards the side
    # that is taken [rad].
    bearing: Annotated[float, Interval(ge=-3.2, le=3.2)] = 0.8
    # Factor on the gain of the active collision cost while an obstacle is
    # passed on a side.
    active_scale: Annotated[float, Interval(ge=0, le=10)] = 0.5

    def propose(self, situation: Situation) -> Sequence[Sequence[Guidance]]:
        """Proposes direct, left and right for each tier.

        Left and right turn the base: a robot without one only goes direct.

        Args:
            situation: The stopping distances that may be tried, and the robot;
                its other values do not matter here.
        """
        if not situation.robot.n_base:
            return [[Guidance("direct", stopping=t)] for t in situation.tiers]
        return make_candidates(situation.tiers, self.bearing, self.active_scale)
