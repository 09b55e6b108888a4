"""`OwnWork`: memory in which kernels look at whether a robot keeps off itself.

Numba counts the references to memory that a kernel allocates, atomically at
each handover; that took longer than the looks themselves. Memory of Python's is
not counted.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.robot.kinematics import TreeArrays
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays

DEPTH = 12
"""How often a motion may be halved, and once more."""

MOST = 2 ** (DEPTH - 2)
"""Most parts into which a motion is cut."""

_KEPT = 16
"""Most looks at a motion that are kept; few are taken."""


class OwnWork(NamedTuple):
    """Looks at a robot with b bodies, s shapes on l links and k pairs of them.

    Attributes:
        row: For each time the row of its look, -1 where none is kept, shape
            (`MOST` + 1,).
        is_taken: Whether a row holds a look, shape (m,), bool; the last never
            does, it is for looks that are not kept.
        X_WL: Poses of all bodies at the looks, shape (m, b, 4, 4).
        p_WC: Centres of the shapes, shape (m, s, 3) [m].
        p_WL: Centres of the links' boxes, shape (m, l, 3) [m].
        guess: Directions from the first shape of each pair to the second, in
            the first's link, as they were found last, shape (k, 3).
        guess_W: One of them in W, shape (3,).
        stack: Times of looks, shape (`DEPTH`,).
        room: Rooms at these, shape (`DEPTH`,) [m].
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
