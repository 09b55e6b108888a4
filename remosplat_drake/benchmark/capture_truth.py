"""The true surfaces of a real scene, as far as its capture knows them."""

import numpy as np

from remosplat_drake.capture.capture import Capture

VOXEL = 0.01
"""Points are averaged over cubes of this side [m]."""

MIN_PIXELS = 8
"""Cubes with fewer pixels are noise, mostly beside silhouettes."""

MAX_JUMP = 0.03
"""Depth that changes by more than this part of itself from a pixel to the
next belongs to no surface: sensors interpolate across silhouettes."""


def surface_points(
    capture: Capture, X_WG: np.ndarray, max_depth: float
) -> np.ndarray:
    """Points on the surfaces that the capture's depth shows.

    Args:
        capture: In its own world frame G.
        X_WG: Pose of that frame in W, shape (4, 4).
        max_depth: Farther pixels are left out [m].

    Returns:
        Mean points of cubes of side `VOXEL`, shape (n, 3), in W [m].
    """
    cubes, sums, counts = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)
    for view in range(len(capture)):
        depth = capture.depth[view]
        keep = is_surface(depth) & (depth < max_depth)
        p_GP = capture.points_W(view)[keep]
        p_WP = p_GP @ X_WG[:3, :3].T + X_WG[:3, 3]
        # Merging view by view keeps one copy of the scene in memory.
        cubes, place = np.unique(
            np.concatenate([cubes, _cube(p_WP)]), return_inverse=True
        )
        points = np.concatenate([sums, p_WP])
        weights = np.concatenate([counts, np.ones(len(p_WP))])
        sums = np.stack(
            [np.bincount(place, column, len(cubes)) for column in points.T],
            axis=1,
        )
        counts = np.bincount(place, weights, len(cubes))
    dense = counts >= MIN_PIXELS
    return sums[dense] / counts[dense, None]


def _cube(p_WP: np.ndarray) -> np.ndarray:
    """One number for the cube of each point; good for 10 km around W."""
    i, j, k = (np.floor(p_WP / VOXEL).astype(np.int64) + (1 << 20)).T
    return (i << 42) | (j << 21) | k


def is_surface(depth: np.ndarray) -> np.ndarray:
    """Pixels (h, w) whose depth is known and like its neighbours'."""
    along_v = np.abs(np.gradient(depth.astype(float), axis=0))
    along_u = np.abs(np.gradient(depth.astype(float), axis=1))
    jump = np.maximum(along_v, along_u)
    return (depth > 0) & (jump < MAX_JUMP * depth)
