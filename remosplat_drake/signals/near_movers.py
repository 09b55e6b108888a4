"""`NearMovers`: which of the robot's spheres are near something that moves."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.kernels.mover_reach import near_movers
from remosplat_drake.scene.mover import Movers


@dc.dataclass(frozen=True, eq=False)
class NearMovers:
    """m pairs of a sphere and a mover; copying returns the object itself.

    Attributes:
        sphere: Index of the sphere, shape (m,).
        names: Names of the movers, m of them.
        distance: Distance from the sphere's surface to wherever the mover can
            be now, shape (m,) [m]; negative where it can touch.
        direction_W: Unit vectors from the sphere's centre towards the mover,
            in W, shape (m, 3).
        closing: Speeds at which the movers come nearer by themselves, shape
            (m,) [m/s].
    """

    sphere: np.ndarray
    names: tuple[str, ...]
    distance: np.ndarray
    direction_W: np.ndarray
    closing: np.ndarray

    def __deepcopy__(self, memo) -> "NearMovers":
        return self

    def __len__(self) -> int:
        return len(self.distance)

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
        sphere, mover, distance, direction_W, closing = near_movers(
            movers.at(time),
            np.array(spheres.p_WS, float),
            np.array(spheres.radius, float),
            float(within),
        )
        names = tuple(movers.movers[j].name for j in mover)
        return NearMovers(sphere, names, distance, direction_W, closing)
