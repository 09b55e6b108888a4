"""Classifies the space of a box by what the cameras of a capture saw."""

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.signals.coverage import (
    FREE,
    SURFACE,
    UNSEEN,
    Coverage,
    grid_shape,
)


def make_coverage(
    capture: Capture,
    surface_W: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    voxel: float = 0.05,
) -> Coverage:
    """Classifies the voxels of a box as surface, free or unseen.

    A voxel is surface if it contains a measured point. Otherwise it is free if
    a camera measured a depth behind its centre. All other voxels are unseen,
    including the inside of objects.

    Args:
        capture: Posed RGB-D images.
        surface_W: Measured points, shape (n, 3) [m].
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].
    """
    shape = grid_shape(lower, upper, voxel)
    index = np.argwhere(np.ones(shape, bool))
    centers = lower + voxel * (index + 0.5)
    free = times_looked_through(capture, centers, margin=voxel / 4) > 0
    state = np.where(free, FREE, UNSEEN).astype(np.uint8).reshape(shape)
    cell = np.floor((surface_W - lower) / voxel).astype(int)
    inside = ((cell >= 0) & (cell < shape)).all(axis=1)
    state[tuple(cell[inside].T)] = SURFACE
    return Coverage(np.asarray(lower, float), voxel, state)
