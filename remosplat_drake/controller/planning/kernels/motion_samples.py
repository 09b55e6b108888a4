"""`MotionSamples`: a part of a motion at eight equidistant times.

Both ends of the part are among them. SIMD lanes hold the values of the eight
samples, so that eight samples take little longer than one.

Let r_k be the excess of a distance over the required one at a sample, and s_k a
bound on the path of the moving point from there to the next sample. If r_k +
r_(k+1) is at least s_k, the required distance is kept in between; see
`between_samples.py`.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import (
    WIDTH,
    first_lanes,
    in_all,
    lanes_from,
    places_of,
    root,
    write_lanes,
)
from remosplat_drake.robot.kinematics import TreeArrays, advance
from remosplat_drake.robot.pose_lanes import place_bodies

PARTS = WIDTH - 1
"""Number of parts between the samples."""

ALL_PARTS = 2**PARTS - 1
"""All parts between the samples, as a bit mask."""


class MotionSamples(NamedTuple):
    """Samples of a motion of a robot with b bodies.

    Python allocates their memory, for the reason given in `self_work.py`.

    Attributes:
        share: 0, 1/7, 2/7 to 1, shape (8,).
        q: The configurations, shape (n_q, 8) [rad, m].
        X_WL: Poses of all bodies, see `pose_lanes`.
        scratch: Memory of `place_bodies`.
    """

    share: np.ndarray
    q: np.ndarray
    X_WL: np.ndarray
    scratch: np.ndarray

    @staticmethod
    def make(tree: TreeArrays, n_q: int) -> "MotionSamples":
        """Makes the memory for a robot.

        Args:
            tree: The robot's tree.
            n_q: Number of entries of q.
        """
        return MotionSamples(
            np.arange(WIDTH) / PARTS,
            np.zeros((n_q, WIDTH)),
            np.zeros((len(tree.parent), 3, 4, WIDTH)),
            np.zeros((2, 3, 4, WIDTH)),
        )


@helper
def sample_motion(robot, samples, q, u, start, end):
    """Samples a part of a motion.

    Args:
        robot: The `RobotArrays`.
        samples: The `MotionSamples`; written to.
        q: Configuration at which the motion starts, shape (n_q,) [rad, m].
        u: The command, which is held for a second, shape (n_u,).
        start: Time of the first sample [s].
        end: Time of the last sample [s].
    """
    time = lanes_from(samples.share, 0) * (end - start) + start
    first = len(q) - len(u)
    for j in range(robot.n_base, len(u)):
        value = in_all(q[first + j]) + time * u[j]
        write_lanes(samples.q, (first + j) * WIDTH, value)
    if robot.n_base:
        for k in range(WIDTH):
            at = start + samples.share[k] * (end - start)
            there = advance(q, u, robot.n_base, at)
            for j in range(3):
                samples.q[j, k] = there[j]
    place_bodies(robot.tree, samples.q, samples.X_WL, samples.scratch)


@helper
def changes(memory, first, last):
    """Computes the norm of the change from each sample to the next, as lanes.

    Args:
        memory: Rows of eight numbers, one for each sample, and a further number
            at the end.
        first: The first row that counts.
        last: The row after the last one that counts.
    """
    square = in_all(0.0)
    for k in range(first, last):
        change = lanes_from(memory, k * WIDTH + 1)
        change = change - lanes_from(memory, k * WIDTH)
        square = square + change * change
    return root(square)


@helper
def open_parts(margin, way):
    """Returns the parts in which distances may be too small, as bits.

    Args:
        margin: Margins at the eight samples, followed by at least one number
            without effect, shape (9 or more,) [m].
        way: Bounds on the paths to the next sample, as lanes [m].
    """
    both = lanes_from(margin, 0) + lanes_from(margin, 1)
    return places_of(~(both >= way) & first_lanes(PARTS, way))


@helper
def samples_of(parts):
    """Converts a bit mask of parts to one of the samples at their ends."""
    return parts | (parts << 1)
