"""`StandingMovers`: movers that stand in the way of a path."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.kernels.mover_reach import MoverArrays
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.near_movers import NearMovers

_START = 0.1
"""A path leaves the room that these may need when they move again: what they
can get to in so much time [s]. It can be followed so much the faster."""


@dc.dataclass(frozen=True, eq=False)
class StandingMovers:
    """Movers that stand, as a path must go round them.

    Motions are looked at by verification's own sweep, as if they could not
    move.

    Attributes:
        movers: The movers, at rest, stamped now, and as large as what they
            keep clear of the robot.
    """

    movers: Movers

    @staticmethod
    def make(movers: Movers, separation: float) -> "StandingMovers":
        """Makes them of movers at rest.

        Args:
            movers: The movers, stamped now.
            separation: Distance that spheres keep from them [m].
        """
        return StandingMovers(
            Movers(movers.stamp, [_swollen(m, separation) for m in movers])
        )

    @property
    def arrays(self) -> MoverArrays:
        """The movers, packed for kernels."""
        return self.movers.at(self.movers.stamp)

    def levels(self, spheres: Spheres) -> np.ndarray:
        """Returns the distances that spheres keep from them, (n,) [m].

        A sphere that is nearer than it should be must not come nearer still.

        Args:
            spheres: The robot's n spheres at the start.
        """
        near = NearMovers.find(self.movers, self.movers.stamp, spheres, 0.0)
        level = np.zeros(len(spheres))
        np.minimum.at(level, near.sphere, near.distance)
        return level


NOTHING_STANDS = StandingMovers(Movers(0.0, []))
"""Nothing stands in the way."""


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
