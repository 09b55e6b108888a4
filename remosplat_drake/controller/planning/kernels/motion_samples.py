"""`MotionSamples`: samples of a part of a motion at eight equidistant times.

The samples include both ends of the part. SIMD lanes contain the values of the
eight samples, so computing eight samples takes little longer than computing
one.

Let r_k be the margin at a sample, which is a distance minus the required
distance. Let s_k be a bound of the path of the moving point from this sample to
the next. If r_k + r_(k+1) is at least s_k, the required distance is kept
between the samples; see `between_samples.py`.
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
    """Memory for samples of a motion of a robot with b bodies.

    Python allocates this memory; `self_work.py` states the reason.

    Attributes:
        share: The fractions 0, 1/7, 2/7, ..., 1, shape (8,).
        q: The configurations, shape (n_q, 8) [rad, m].
        X_WL: Poses of all bodies; see `pose_lanes`.
        scratch: Working memory of `place_bodies`.
    """

    share: np.ndarray
    q: np.ndarray
    X_WL: np.ndarray
    scratch: np.ndarray

    @staticmethod
    def make(tree: TreeArrays, n_q: int) -> "MotionSamples":
        """Allocates the memory for a robot.

        Args:
            tree: The robot's kinematic tree.
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
        samples: Output: the `MotionSamples`.
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
    """Returns the norm of the change from each sample to the next, as lanes.

    Args:
        memory: Rows of eight numbers, one number for each sample. After the
            last row, there is a further number.
        first: Index of the first row.
        last: Index after that of the last row.
    """
    square = in_all(0.0)
    for k in range(first, last):
        change = lanes_from(memory, k * WIDTH + 1)
        change = change - lanes_from(memory, k * WIDTH)
        square = square + change * change
    return root(square)


@helper
def open_parts(margin, way):
    """Returns the parts in which distances may be too small, as a bit mask.

    Args:
        margin: Margins at the eight samples, shape (9 or more,) [m]. Further
            numbers have no effect.
        way: Bounds of the paths to the next sample, as lanes [m].
    """
    both = lanes_from(margin, 0) + lanes_from(margin, 1)
    return places_of(~(both >= way) & first_lanes(PARTS, way))


@helper
def samples_of(parts):
    """Converts a bit mask of parts to one of the samples at their ends."""
    return parts | (parts << 1)
