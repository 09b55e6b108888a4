"""What proposes the guidances among which the selector chooses."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Annotated, Protocol

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.guidance.guidance import (
    Guidance,
    make_candidates,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True, eq=False)
class Situation:
    """What is known when the present guidance is seen not to arrive.

    Attributes:
        robot: The robot.
        q: Its configuration, shape (n_q,).
        X_WT: Target pose, shape (4, 4).
        field: The map, as rollouts know it.
        tiers: Stopping distances in the order in which they may be tried,
            largest first [m].
    """

    robot: RobotModel
    q: np.ndarray
    X_WT: np.ndarray
    field: DistanceField
    tiers: tuple[float, ...]


class GuidancePlanner(Protocol):
    """Proposes what may be tried: `SidePlanner`, or one's own."""

    def propose(self, situation: Situation) -> Sequence[Sequence[Guidance]]:
        """The candidates of a round of selection, tier after tier.

        All of a tier are rolled out; the next tier is tried if nothing of
        those before arrives. Nothing of safety rests on them.

        Args:
            situation: What is known.
        """
        ...


@dc.dataclass
class SidePlanner(Config):
    """Direct, left and right, at every stopping distance."""

    # Angle by which the base turns from the end effector towards the side
    # that is taken [rad].
    bearing: Annotated[float, Interval(ge=-3.2, le=3.2)] = 0.8
    # Factor on the active collision cost while passing on a side.
    active_scale: Annotated[float, Interval(ge=0, le=10)] = 0.5

    def propose(self, situation: Situation) -> Sequence[Sequence[Guidance]]:
        """See `GuidancePlanner`."""
        return make_candidates(situation.tiers, self.bearing, self.active_scale)
