"""Rounds off the corners of a path.

A robot must pass a corner slowly, since its velocity changes instantly at the
corner.
"""

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.blends import blended


def blended_corners(
    space: FreeSpace, corners: np.ndarray, longest: float
) -> np.ndarray:
    """Replaces the corners of a path by collision-free blends.

    A differential base must stop between turning and driving, so a path keeps
    the corners between a turn and a drive.

    Args:
        space: The free space.
        corners: Corners of a free path, shape (k, n_q) [rad, m]. Consecutive
            corners must differ.
        longest: A blend ends at most at this distance in q from its corner. A
            radian counts like a metre.

    Returns:
        Corners of the blended path, shape (m, n_q) [rad, m].
    """
    if space.robot.n_base == 2 or len(corners) < 3:
        return corners
    with space.calls() as line:
        return blended(space.arrays, line, np.array(corners), float(longest))
