"""`SelfWork`: working memory of kernels that check for self-collision.

Numba counts references to memory that a kernel allocates, with an atomic
operation at each call. That takes longer than the checks themselves. References
to memory that Python has allocated are not counted.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.part_stack import PartStack
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays


class SelfMotionWork(NamedTuple):
    """Memory for motions with s shapes, k pairs of these and l pairs of links.

    Attributes:
        p_WC: Centres of the shapes at the samples, shape (s, 3, 8) [m].
        p_WL: Centres of the links' boxes, the same.
        pose: Pose of a link in another one, shape (13, 8).
        margin: Margins between two links or shapes at the samples, shape (16,)
            [m].
        n_A: For each pair of shapes, the latest direction that separated them,
            from the first shape to the second: a unit vector in the frame A of
            the first one's link, initially zero, shape (k, 3).
        speed: Bounds on the speeds at which links approach each other, shape
            (l,) [m/s].
        bend: Bounds on the accelerations of links, shape (l,), padded [m/s^2].
        parts: Parts of the motion, with pairs of links.
        X_WA: Pose of a link, shape (4, 4).
        X_WB: Pose of another, shape (4, 4).
        n_W: One of the directions in W, shape (3,).
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
        """Makes the memory.

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
        margin: Margins of the links at the latest free configuration: lower
            bounds on their distances minus the required ones, shape (l,) [m].
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
        """Makes the memory; see `SelfMotionWork.make`."""
        return SelfWork(
            p_WC=np.zeros((len(pairs.shapes.body), 3)),
            p_WL=np.zeros((len(pairs.link_boxes.body), 3)),
            margin=np.zeros(len(pairs.boxes)),
            offset_W=np.zeros(3),
            gjk=make_work(),
            motion=SelfMotionWork.make(pairs, bends),
        )
