"""`NearMovers`: which of the robot's spheres are near something that moves."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.kernels.mover_reach import near_movers
from remosplat_drake.scene.mover import Movers

_BESIDE = 0.05
"""How far beside a mover a map may show its surface [m]."""


@dc.dataclass(frozen=True, eq=False)
class NearMovers:
    """m pairs of a sphere and a mover; copying returns the object itself.

    Attributes:
        sphere: Index of the sphere, shape (m,).
        mover: Index of the mover, shape (m,).
        distance: Distance from the sphere's surface to wherever the mover can
            be now, shape (m,) [m]; negative where it can touch.
        direction_W: Unit vectors from the sphere's centre towards the mover,
            in W, shape (m, 3).
        closing: Speeds at which the movers come nearer by themselves, shape
            (m,) [m/s].
    """

    sphere: np.ndarray
    mover: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray
    closing: np.ndarray

    def __deepcopy__(self, memo) -> "NearMovers":
        return self

    def __len__(self) -> int:
        return len(self.distance)

    def approach_rates(self, Jv_WS: np.ndarray) -> np.ndarray:
        """Returns n' Jv_WS of each pair: a sphere's part in its approach.

        Args:
            Jv_WS: Translational Jacobians of the n spheres' centres in W,
                shape (n, 3, n_u).

        Returns:
            The rows, shape (m, n_u).
        """
        return np.einsum("mi,mij->mj", self.direction_W, Jv_WS[self.sphere])

    @staticmethod
    def none() -> "NearMovers":
        """Makes those of a world in which nothing moves."""
        which, value = np.zeros(0, int), np.zeros(0)
        return NearMovers(which, which, value, np.zeros((0, 3)), value)

    @staticmethod
    def find(
        movers: Movers, time: float, spheres: Spheres, within: float
    ) -> "NearMovers":
        """Finds what moves near the robot.

        Args:
            movers: What moves.
            time: The present time [s].
            spheres: The robot's spheres, placed in W.
            within: Pairs at or beyond this distance are left out [m].
        """
        return NearMovers(
            *near_movers(
                movers.at(time),
                np.array(spheres.p_WS, float),
                np.array(spheres.radius, float),
                float(within),
            )
        )


def mover_at(movers: Movers | None, time: float, p_W: np.ndarray) -> str:
    """Names the mover whose surface a place may be on; empty if there is none.

    A map that is made while somebody stands there shows them, too. So what a
    clearance is too small before may be a mover, and no fault of the map.

    Args:
        movers: What moves; None if nothing is known to.
        time: The present time [s].
        p_W: The place in W, shape (3,) [m].
    """
    if movers is None:
        return ""
    near = NearMovers.find(movers, time, Spheres.at(p_W), _BESIDE)
    if not len(near):
        return ""
    return movers.movers[near.mover[near.distance.argmin()]].name
