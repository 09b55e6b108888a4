"""`MapWork`: memory in which kernels look at whether a robot keeps off a map.

As for `OwnWork`, memory of Python's is not counted by Numba.
"""

from typing import NamedTuple

import numpy as np


class MapWork(NamedTuple):
    """Looks at m balls and spheres.

    Attributes:
        item: Those to look at, shape (m,).
        opened: Balls of which the spheres are looked at next, shape (m,).
        bend: Bounds on how fast velocities change, shape (m,) [m/s^2].
        p_WS: Where the centres are, shape (m, 3) [m].
        p_before: Where one of them is at the end of a part, shape (3,) [m].
        reach: Clearances up to which answers are exact, shape (m,) [m].
        found: Clearances, shape (m,) [m].
        room: Rooms, shape (m,) [m].
        wanted: Rooms that are wanted, shape (m,) [m].
    """

    item: np.ndarray
    opened: np.ndarray
    bend: np.ndarray
    p_WS: np.ndarray
    p_before: np.ndarray
    reach: np.ndarray
    found: np.ndarray
    room: np.ndarray
    wanted: np.ndarray

    @staticmethod
    def make(m: int) -> "MapWork":
        """Makes the memory.

        Args:
            m: Number of balls and spheres.
        """
        whole, real = np.zeros((2, m), np.int64), np.zeros((5, m))
        return MapWork(
            whole[0].copy(),
            whole[1].copy(),
            real[0].copy(),
            np.zeros((m, 3)),
            np.zeros(3),
            *(row.copy() for row in real[1:]),
        )
