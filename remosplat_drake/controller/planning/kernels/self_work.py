"""`SelfWork`: working memory of kernels that check for self-collision.

Python allocates this memory. If a kernel allocated it, Numba would count the
references to it, with an atomic operation at each call, which takes longer than
the checks. References to memory that Python has allocated are not counted.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.part_stack import PartStack
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays


class SelfMotionWork(NamedTuple):
    """Memory for motions of s shapes, with k pairs of shapes, l pairs of links.

    Attributes:
        p_WC: Centres of the shapes at the samples, shape (s, 3, 8) [m].
        p_WL: Centres of the links' boxes at the samples, in the same form.
        pose: Pose of a link in the frame of another link, shape (13, 8).
        margin: Margins between two links or shapes at the samples, shape (16,)
            [m].
        n_A: Latest direction that separated each pair of shapes, from the first
            shape to the second, shape (k, 3). It is a unit vector in the frame
            A of the first shape's link, and is initially zero.
        speed: Bounds of the speeds at which links approach each other, shape
            (l,) [m/s].
        bend: Bounds of the accelerations of links, shape (l,), padded [m/s^2].
        parts: Parts of the motion, with pairs of links.
        X_WA: Pose of a link, shape (4, 4).
        X_WB: Pose of another link, shape (4, 4).
        n_W: A direction of `n_A` in W, shape (3,).
    """

    p_WC: np.ndarray
    p_WL: np.ndarray
    pose: np.ndarray
    margin: np.ndarray
    n_A: np.ndarray
    speed: np.ndarray
    bend: np.ndarray
    parts: PartStack
    X_WA: np.ndarray
    X_WB: np.ndarray
    n_W: np.ndarray

    @staticmethod
    def make(pairs: PairArrays, bends: int) -> "SelfMotionWork":
        """Allocates the memory.

        Args:
            pairs: The pairs of shapes.
            bends: Length of `bend`.
        """
        return SelfMotionWork(
            p_WC=np.zeros((len(pairs.shapes.body), 3, WIDTH)),
            p_WL=np.zeros((len(pairs.link_boxes.body), 3, WIDTH)),
            pose=np.zeros((13, WIDTH)),
            margin=np.zeros(2 * WIDTH),
            n_A=np.zeros((len(pairs.first), 3)),
            speed=np.zeros(len(pairs.boxes)),
            bend=np.zeros(bends),
            parts=PartStack.make(len(pairs.boxes)),
            X_WA=np.eye(4),
            X_WB=np.eye(4),
            n_W=np.zeros(3),
        )


class SelfWork(NamedTuple):
    """Memory for s shapes, l boxes of links and k pairs of shapes.

    Attributes:
        p_WC: Centres of the shapes, shape (s, 3) [m].
        p_WL: Centres of the links' boxes, shape (l, 3) [m].
        margin: Margins of the pairs of links in the latest free configuration:
            lower bounds of their distances minus the required distances, shape
            (l,) [m].
        offset_W: Vector from a shape to another in W, shape (3,) [m].
        gjk: Arrays of `gjk.make_work`.
        motion: Memory for motions.
    """

    p_WC: np.ndarray
    p_WL: np.ndarray
    margin: np.ndarray
    offset_W: np.ndarray
    gjk: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    motion: SelfMotionWork

    @staticmethod
    def make(pairs: PairArrays, bends: int) -> "SelfWork":
        """Allocates the memory; see `SelfMotionWork.make`."""
        return SelfWork(
            p_WC=np.zeros((len(pairs.shapes.body), 3)),
            p_WL=np.zeros((len(pairs.link_boxes.body), 3)),
            margin=np.zeros(len(pairs.boxes)),
            offset_W=np.zeros(3),
            gjk=make_work(),
            motion=SelfMotionWork.make(pairs, bends),
        )
