"""`OwnWork`: working memory of kernels that check for self-collision.

Numba counts references to memory that a kernel allocates, with an atomic
operation at each call. That takes longer than the checks themselves. References
to memory that Python has allocated are not counted.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.robot.kinematics import TreeArrays
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays

DEPTH = 12
"""Largest number of halvings of a motion, plus one."""

MOST = 2 ** (DEPTH - 2)
"""Largest number of parts of a motion."""

_KEPT = 16
"""Largest number of stored samples of a motion; few are needed."""


class OwnWork(NamedTuple):
    """Stored samples of a motion, for b bodies, s shapes, l links and k pairs.

    Attributes:
        row: For each time, the row of its stored sample, or -1, shape (`MOST` +
            1,).
        is_taken: Whether a row stores a sample, shape (m,), bool. The last row
            never does; it is for samples that are not stored.
        X_WL: Poses of all bodies at the samples, shape (m, b, 4, 4).
        p_WC: Centres of the shapes, shape (m, s, 3) [m].
        p_WL: Centres of the links' boxes, shape (m, l, 3) [m].
        guess: The latest computed directions from the first to the second shape
            of each pair, in the frame of the first shape's link, shape (k, 3).
        guess_W: One of them in W, shape (3,).
        stack: Times of samples, shape (`DEPTH`,).
        room: Rooms at these times, shape (`DEPTH`,) [m].
        gjk: Arrays of `gjk.make_work`.
    """

    row: np.ndarray
    is_taken: np.ndarray
    X_WL: np.ndarray
    p_WC: np.ndarray
    p_WL: np.ndarray
    guess: np.ndarray
    guess_W: np.ndarray
    stack: np.ndarray
    room: np.ndarray
    gjk: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]

    @staticmethod
    def make(tree: TreeArrays, pairs: PairArrays) -> "OwnWork":
        """Makes the memory for a robot.

        Args:
            tree: The robot's tree.
            pairs: The pairs of its shapes.
        """
        m = _KEPT + 1
        return OwnWork(
            row=np.zeros(MOST + 1, np.int64),
            is_taken=np.zeros(m, bool),
            X_WL=np.zeros((m, len(tree.parent), 4, 4)),
            p_WC=np.zeros((m, len(pairs.shapes.body), 3)),
            p_WL=np.zeros((m, len(pairs.link_boxes.body), 3)),
            guess=np.zeros((len(pairs.first), 3)),
            guess_W=np.zeros(3),
            stack=np.zeros(DEPTH, np.int64),
            room=np.zeros(DEPTH),
            gjk=make_work(),
        )
