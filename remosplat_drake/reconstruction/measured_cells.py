"""Finds cells of space with measured points, which are not free.

A view samples space only along its pixels' rays. If a rod is thinner than their
distance, some pixels measure a part of it, and rays of others pass beside the
rest. So a single measured point outweighs all views that have looked through
its cell, except those with pixels so close together that no thin thing fits
between them.
"""

import dataclasses as dc
from itertools import product

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.whole_looks import count_whole_looks
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage, grid_shape

CELLS = 3
"""Number of cells along a voxel's edge."""

MARGIN = 0.01
"""Distance behind free space at which a view must have a measurement [m]."""

THINNEST = 0.003
"""Largest distance between pixels at a cell for views that may mark it as free
in spite of a measured point [m]."""


def measured_cells(
    capture: Capture, lower: np.ndarray, upper: np.ndarray, voxel: float
) -> np.ndarray:
    """Finds the cells of a box that hold a measured point.

    Args:
        capture: Posed RGB-D images.
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].

    Returns:
        Their indices along the box's axes, shape (n, 3).
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
    """Marks free voxels with a measured cell in or beside them as unseen.

    Args:
        coverage: The seen space, in W.
        cells: The result of `measured_cells` in its box.
        looks: The views that may still mark a voxel as free.

    Returns:
        The same, with such voxels unseen.
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
    """Returns which cubes of a grid a view with fine pixels looked through.

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
