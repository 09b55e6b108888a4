"""Rounds off the corners of a path.

The robot must pass a corner slowly, since its velocity changes instantly there.
"""

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.blends import blended


def blended_corners(
    space: FreeSpace, corners: np.ndarray, longest: float
) -> np.ndarray:
    """Replaces the corners of a path by collision-free blends.

    A differential base must stop between turning and driving, so its paths keep
    the corners between the two.

    Args:
        space: The free space.
        corners: Corners of a free path, no two neighbours equal, shape
            (k, n_q) [rad, m].
        longest: Largest distance in q from a corner to the ends of its blend; a
            radian counts like a metre.

    Returns:
        Corners of the blended path, shape (m, n_q) [rad, m].
    """
    if space.robot.n_base == 2 or len(corners) < 3:
        return corners
    with space.calls() as line:
        return blended(space.arrays, line, np.array(corners), float(longest))
