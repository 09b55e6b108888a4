"""`StandingMovers`: standing movers as obstacles for paths."""

import dataclasses as dc
from functools import cached_property

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.kernels.mover_reach import MoverArrays
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.near_movers import NearMovers

_START = 0.1
"""Paths avoid all places that a standing mover could reach within this time
[s]. So the robot can pass the mover at a higher speed."""


@dc.dataclass(frozen=True, eq=False)
class StandingMovers:
    """Standing movers, enlarged by the distance that paths keep from them.

    Planned motions are checked by the same function as in verification, for
    which these movers do not move.

    Attributes:
        movers: The movers at rest, enlarged by the required distance. Their
            stamp is the present time.
    """

    movers: Movers

    @staticmethod
    def make(movers: Movers, separation: float) -> "StandingMovers":
        """Makes the obstacles from movers at rest.

        Args:
            movers: The movers, whose stamp is the present time.
            separation: Distance that spheres keep from movers [m].
        """
        return StandingMovers(
            Movers(movers.stamp, [_swollen(m, separation) for m in movers])
        )

    @cached_property
    def arrays(self) -> Packed[MoverArrays]:
        """The movers, packed for kernels."""
        return Packed(self.movers.at(self.movers.stamp))

    def levels(self, robot: RobotModel, q: np.ndarray) -> np.ndarray:
        """Returns the distances from the movers that spheres keep, (n,) [m].

        A sphere that is already nearer keeps its present distance.

        Args:
            robot: The robot, with n spheres.
            q: Configuration at the start, shape (n_q,) [rad, m].
        """
        level = np.zeros(len(robot.spheres))
        if not self.movers.movers:
            return level
        spheres = robot.spheres_at(q)
        near = NearMovers.find(self.movers, self.movers.stamp, spheres, 0.0)
        np.minimum.at(level, near.sphere, near.distance)
        return level


NOTHING_STANDS = StandingMovers(Movers(0.0, []))
"""The value if there are no standing movers."""


def _swollen(mover: Mover, separation: float) -> Mover:
    start = min(0.5 * mover.max_acceleration * _START, mover.max_speed)
    kept = separation + mover.position_error + start * _START
    return Mover(
        mover.name,
        mover.X_WM,
        mover.half_extents,
        mover.radius + kept,
        max_speed=0.0,
        max_acceleration=0.0,
    )
