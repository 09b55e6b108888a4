"""`StandingMovers`: what moves otherwise, in the way of a path."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.verification.kernels.between_looks import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.kernels.mover_sweep import (
    keeps_off_movers,
)
from remosplat_drake.controller.verification.kernels.places import held
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.near_movers import NearMovers

_START = 0.1
"""A path leaves the room that these may need when they move again: what they
can get to in so much time [s]. It can be followed so much the faster."""

_LOOK = 0.02
"""How far a sphere moves between two looks [m]."""


@dc.dataclass(frozen=True, eq=False)
class StandingMovers:
    """Movers that stand, as a path must go round them.

    Motions are looked at by verification's own sweep, as if they could not
    move.

    Attributes:
        movers: The movers, at rest, stamped now, and as large as what they
            keep clear of the robot.
        level: How far spheres stay off that, shape (n,) or for all [m]: less
            than 0 where they are nearer at the start.
    """

    movers: Movers
    level: np.ndarray | float = 0.0

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

    def seen_from(self, spheres: Spheres) -> "StandingMovers":
        """Returns them as who starts there may go round them.

        A sphere that is nearer than it should be must not come nearer still.

        Args:
            spheres: The robot's spheres at the start.
        """
        level = np.minimum(0.0, self.distance(spheres))
        return dc.replace(self, level=level)

    def obstructs(self, spheres: Spheres) -> bool:
        """Tells whether any of them is nearer to a sphere than it may be.

        Args:
            spheres: The robot's spheres somewhere.
        """
        return bool((self.distance(spheres) < self.level).any())

    def is_passed(
        self, robot: RobotModel, q: np.ndarray, u: np.ndarray, travel: float
    ) -> bool:
        """Tells whether a motion keeps off all of them.

        Args:
            robot: The robot.
            q: Configuration at which it starts, shape (n_q,) [rad, m].
            u: The command that is held for a second, shape (n_u,).
            travel: Longest way of a sphere [m].
        """
        looks = max(1, round(travel / _LOOK))
        times = np.linspace(0.0, 1.0, looks + 1)[1:]
        return keeps_off_movers(
            robot.arrays,
            held(q, u, robot.n_base, times, times),
            self.movers.at(self.movers.stamp),
            np.array(robot.spheres_at(q).p_WS),
            0.0,
            np.zeros(len(robot.spheres)),
            TOLERANCE,
        )

    def distance(self, spheres: Spheres) -> np.ndarray:
        """Measures how far each sphere is from the nearest of them, (n,) [m].

        Args:
            spheres: The robot's spheres somewhere.
        """
        near = NearMovers.find(self.movers, self.movers.stamp, spheres, np.inf)
        distance = np.full(len(spheres), np.inf)
        np.minimum.at(distance, near.sphere, near.distance)
        return distance


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
