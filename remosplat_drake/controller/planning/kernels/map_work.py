"""`MapWork`: working memory of kernels that check distances from a map.

Python allocates this memory; `self_work.py` states the reason.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.part_stack import PartStack


class MapQueries(NamedTuple):
    """Memory for at most n queries of a map.

    Attributes:
        item: Index of the ball or sphere of each query, shape (n,).
        p_WS: Centre of this ball or sphere in W, shape (n, 3) [m].
        R_WL: Orientation of its link, shape (n, 3, 3). Only maps in Python use
            it.
        wanted: Margins up to these values are computed exactly, shape (n,) [m].
        reach: Clearances up to these values are computed exactly, shape (n,)
            [m].
        margin: Output: margins, which are clearances minus required clearances,
            shape (n,) [m].
    """

    item: np.ndarray
    p_WS: np.ndarray
    R_WL: np.ndarray
    wanted: np.ndarray
    reach: np.ndarray
    margin: np.ndarray

    @staticmethod
    def make(n: int) -> "MapQueries":
        """Allocates the memory.

        Args:
            n: Largest number of queries.
        """
        return MapQueries(
            np.zeros(n, np.int64),
            np.zeros((n, 3)),
            np.zeros((n, 3, 3)),
            np.zeros(n),
            np.zeros(n),
            np.zeros(n),
        )


class MapWork(NamedTuple):
    """Memory for checks of m balls and spheres.

    Attributes:
        queries: The queries.
        parts: Parts of a motion, with balls and spheres.
        speed: Absolute values of the command, shape (n_u,).
        bend: Bounds of accelerations, shape (m,) [m/s^2]; -1 if a bound has not
            been computed yet.
        p_WS: Centres in W of a ball or sphere at eight samples, and padding of
            the same size, shape (2, 3, 8) [m].
        way: Bounds of the paths from each sample to the next, shape (m, 8) [m].
        either: Memory for a row of `way` with one number before it and one
            after it, shape (10,) [m].
        wanted: Margins up to which results are exact at the samples, shape (8,)
            [m].
        margin: Margins at the samples, shape (16,) [m].
    """

    queries: MapQueries
    parts: PartStack
    speed: np.ndarray
    bend: np.ndarray
    p_WS: np.ndarray
    way: np.ndarray
    either: np.ndarray
    wanted: np.ndarray
    margin: np.ndarray

    @staticmethod
    def make(m: int, n_u: int) -> "MapWork":
        """Allocates the memory.

        Args:
            m: Number of balls and spheres.
            n_u: Length of the command.
        """
        return MapWork(
            MapQueries.make(WIDTH * m),
            PartStack.make(m),
            np.zeros(n_u),
            np.zeros(m),
            np.zeros((2, 3, WIDTH)),
            np.zeros((m, WIDTH)),
            np.zeros(WIDTH + 2),
            np.zeros(WIDTH),
            np.zeros(2 * WIDTH),
        )
