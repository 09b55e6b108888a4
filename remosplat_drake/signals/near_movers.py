"""`NearMovers`: the robot's spheres that are near movers (moving objects)."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.kernels.mover_reach import near_movers
from remosplat_drake.scene.mover import Movers

_BESIDE = 0.05
"""A mapped surface may be a part of a mover if their distance is at most this
length [m]."""


@dc.dataclass(frozen=True, eq=False)
class NearMovers:
    """Pairs of a robot sphere and a near mover; a copy is the object itself.

    Attributes:
        sphere: Index of the sphere of each of the m pairs, shape (m,).
        mover: Index of the mover of each pair, shape (m,).
        distance: Least possible distance between the surfaces of sphere and
            mover, shape (m,) [m]; negative if the two may touch.
        direction_W: Unit vectors from the sphere's centre towards the mover,
            in W, shape (m, 3).
        closing: Part of the approach speed that the mover's motion causes,
            shape (m,) [m/s].
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
        """Returns the rows n' Jv_WS, which map u to each pair's approach speed.

        Args:
            Jv_WS: Translational Jacobians of the n spheres' centres in W,
                shape (n, 3, n_u).

        Returns:
            The rows, shape (m, n_u).
        """
        return np.einsum("mi,mij->mj", self.direction_W, Jv_WS[self.sphere])

    @staticmethod
    def none() -> "NearMovers":
        """Makes the value for a world without movers."""
        which, value = np.zeros(0, int), np.zeros(0)
        return NearMovers(which, which, value, np.zeros((0, 3)), value)

    @staticmethod
    def find(
        movers: Movers,
        time: float,
        spheres: Spheres,
        within: float,
        by: float = 0.0,
    ) -> "NearMovers":
        """Finds the movers near the robot.

        Args:
            movers: The movers.
            time: The present time [s].
            spheres: The robot's spheres, placed in W.
            within: Pairs at or beyond this distance are omitted [m].
            by: Look-ahead time [s]. Distances are reduced by the greatest
                deviation from their predicted motion that the movers may have
                after this time.
        """
        return NearMovers(
            *near_movers(
                movers.at(time),
                np.array(spheres.p_WS, float),
                np.array(spheres.radius, float),
                float(within),
                float(by),
            )
        )


def mover_at(movers: Movers | None, time: float, p_W: np.ndarray) -> str:
    """Returns the name of the mover to which a point may belong; "" for none.

    A point on a surface of the map may belong to a mover. For example, if a
    person is in view while a map is built, the map contains this person.

    Args:
        movers: The movers; None if none are known.
        time: The present time [s].
        p_W: The point in W, shape (3,) [m].
    """
    if movers is None:
        return ""
    near = NearMovers.find(movers, time, Spheres.at(p_W), _BESIDE)
    if not len(near):
        return ""
    return movers.movers[near.mover[near.distance.argmin()]].name
