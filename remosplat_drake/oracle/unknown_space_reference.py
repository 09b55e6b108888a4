"""Slow reference of the distance to unseen space, by search of all voxels.

Tests compare `UnknownSpaceField` with it.
"""

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres


def signed_distances(
    unseen: np.ndarray, lower: np.ndarray, voxel: float, spheres: Spheres
) -> np.ndarray:
    """Computes distances to the boundary of unseen space; searches all voxels.

    A layer of unseen voxels around the grid represents all space outside the
    grid.

    Args:
        unseen: Whether each voxel is unseen, shape (nx, ny, nz), bool.
        lower: Lower corner of the grid in W, shape (3,) [m].
        voxel: Edge length of a voxel [m].
        spheres: The n spheres, placed in W.

    Returns:
        Signed distances from the centres, shape (n,) [m]; negative in unseen
        space.
    """
    unseen = np.pad(unseen, 1, constant_values=True)
    low = lower + voxel * (np.argwhere(np.ones(unseen.shape, bool)) - 1)
    center = low + voxel / 2
    result = np.empty(len(spheres))
    for i, p_WS in enumerate(spheres.p_WS):
        solid = unseen.ravel() & (center[:, 2] >= spheres.ignore_below[i])
        gap = np.maximum(low - p_WS, p_WS - (low + voxel))
        distance = np.linalg.norm(np.maximum(gap, 0), axis=1)
        # This is the voxel that contains the centre, or the nearest voxel if
        # the centre is outside the grid.
        home = solid[distance.argmin()]
        others = distance[~solid] if home else distance[solid]
        sign = -1 if home else 1
        result[i] = sign * others.min(initial=np.inf)
    return result
