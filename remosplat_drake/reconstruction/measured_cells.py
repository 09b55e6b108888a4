"""Finds cells of space that contain measured points, so are not free.

A view samples space only along the rays of its pixels. If a rod is thinner than
the distance between two rays, some rays hit the rod, and others pass beside it.
So a cell with a single measured point is not free, even if views have measured
surfaces behind it. It is free only if the rays of a view are so close together
that no thin object fits between them.
"""

import dataclasses as dc
from itertools import product

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.whole_looks import count_whole_looks
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage, grid_shape

CELLS = 3
"""Number of cells along the edge of a voxel."""

MARGIN = 0.01
"""Space is free if a view has measured a surface at least this far behind it
[m]."""

THINNEST = 0.003
"""A view may mark a cell with a measured point as free only if the distance
between its pixels at the cell is at most this [m]."""


def measured_cells(
    capture: Capture, lower: np.ndarray, upper: np.ndarray, voxel: float
) -> np.ndarray:
    """Finds the cells of a box that contain a measured point.

    Args:
        capture: Posed RGB-D images.
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].

    Returns:
        Indices of the cells along the box's axes, shape (n, 3).
    """
    shape = CELLS * np.array(grid_shape(lower, upper, voxel))
    found = np.zeros(shape, bool)
    for view in range(len(capture)):
        p_W = capture.points_W(view)[capture.depth[view] > 0]
        index = np.floor((p_W - lower) * (CELLS / voxel)).astype(int)
        inside = ((index >= 0) & (index < shape)).all(axis=1)
        found[tuple(index[inside].T)] = True
    return np.argwhere(found)


def without_measured(
    coverage: Coverage, cells: np.ndarray, looks: Capture
) -> Coverage:
    """Marks free voxels as unseen if a measured cell is in or beside them.

    Args:
        coverage: The seen space, in W.
        cells: The result of `measured_cells` for the same box.
        looks: Views that may show that a measured cell is free now.

    Returns:
        The seen space with these changes.
    """
    near = np.zeros(coverage.state.shape, bool)
    for step in product((-1, 1), repeat=3):
        voxels = (cells + step) // CELLS
        inside = (voxels >= 0) & (voxels < coverage.state.shape)
        near[tuple(voxels[inside.all(axis=1)].T)] = True
    voxels = np.argwhere(near & (coverage.state == FREE))
    doubted = ~seen_finely(looks, coverage.lower, voxels, coverage.voxel)
    state = coverage.state.copy()
    state[tuple(voxels[doubted].T)] = UNSEEN
    return dc.replace(coverage, state=state)


def seen_finely(
    looks: Capture, lower: np.ndarray, cubes: np.ndarray, edge: float
) -> np.ndarray:
    """Returns a mask of the cubes that closely spaced rays show as free.

    Args:
        looks: Posed RGB-D images.
        lower: Lower corner of the grid in W, shape (3,) [m].
        cubes: Indices of the cubes, shape (n, 3).
        edge: Edge length of the cubes [m].

    Returns:
        Shape (n,), bool.
    """
    corners = lower + edge * cubes
    count = count_whole_looks(
        looks, corners, edge, margin=MARGIN, enough=1, pitch=THINNEST
    )
    return count > 0
