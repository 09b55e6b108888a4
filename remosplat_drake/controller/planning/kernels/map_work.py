"""`MapWork`: working memory of kernels that check distances from a map.

Python allocates it, for the reason given in `own_work.py`.
"""

from typing import NamedTuple

import numpy as np


class MapWork(NamedTuple):
    """Working arrays for m spheres, and balls around several spheres.

    Attributes:
        item: Balls and spheres to check, shape (m,).
        opened: Balls whose enclosed spheres are checked next, shape (m,).
        bend: Bounds on accelerations, shape (m,) [m/s^2].
        p_WS: Centres in W, shape (m, 3) [m].
        p_before: One of these centres at the end of a part, shape (3,) [m].
        reach: Clearances up to which results are exact, shape (m,) [m].
        found: Clearances, shape (m,) [m].
        room: Rooms: clearances minus required clearances, shape (m,) [m].
        wanted: Rooms with which a part of a motion is free, shape (m,) [m].
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
