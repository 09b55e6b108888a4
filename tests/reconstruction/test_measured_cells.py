"""Space at measured pixels is not free, worked by hand before a wall."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_cells import (
    measured_cells,
    without_measured,
)
from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN, Coverage

LOWER, UPPER, VOXEL = (
    np.array([-0.15, -0.15, 1.0]),
    np.array([0.15] * 2 + [2.5]),
    0.1,
)
"""A box of 3 x 3 x 15 voxels."""


def wall(size: int) -> Capture:
    """A camera at the origin that sees a wall at z = 2 and a speck before it.

    It has `size` x `size` pixels, and a field of view of 53 degrees.
    """
    K = np.array([[size, 0, size / 2], [0, size, size / 2], [0, 0, 1.0]])
    depth = np.full((1, size, size), 2, np.float32)
    depth[0, size // 2, size // 2] = 1.25
    return Capture(
        K=K[None],
        X_WC=np.eye(4)[None],
        rgb=np.zeros((1, size, size, 3), np.uint8),
        depth=depth,
    )


def free() -> Coverage:
    state = np.full((3, 3, 15), FREE, np.uint8)
    state[..., 10] = SURFACE
    state[..., 11:] = UNSEEN
    return Coverage(LOWER, VOXEL, state)


def without_speck(capture: Capture) -> Capture:
    return dc.replace(capture, depth=np.full_like(capture.depth, 2))


def test_cells_hold_what_pixels_measured():
    cells = measured_cells(wall(100), LOWER, UPPER, VOXEL)
    speck = cells[cells[:, 2] < 30]
    # The speck is at x = y = 6 mm; a cell is 33 mm wide.
    np.testing.assert_array_equal(speck, [[4, 4, 7]])
    assert (cells[cells[:, 2] >= 30, 2] == 30).all()
    assert len(cells) == 1 + 9 * 9
    blind = dc.replace(wall(100), depth=np.zeros((1, 100, 100), np.float32))
    assert measured_cells(blind, LOWER, UPPER, VOXEL).shape == (0, 3)


@pytest.mark.parametrize(
    ("cell", "unseen"),
    [
        ([4, 4, 7], [[1, 1, 2]]),
        ([4, 4, 8], [[1, 1, 2], [1, 1, 3]]),
        ([0, 0, 0], [[0, 0, 0]]),
        ([4, 4, 31], []),
    ],
)
def test_the_voxels_that_they_touch_are_not_free(cell, unseen):
    before = free()
    after = without_measured(before, np.array([cell]), wall(100))
    changed = np.argwhere(after.state != before.state)
    np.testing.assert_array_equal(changed, np.reshape(unseen, (-1, 3)))
    assert (after.state[tuple(changed.T)] == UNSEEN).all()


@pytest.mark.parametrize(("size", "is_free"), [(300, False), (500, True)])
def test_views_with_fine_pixels_say_that_nothing_is_there(size, is_free):
    """At 1.3 m their pixels are 4.3 or 2.6 mm apart; 3 mm will do."""
    cells = measured_cells(wall(size), LOWER, UPPER, VOXEL)
    looks = without_speck(wall(size))
    after = without_measured(free(), cells, looks)
    assert (after.state[1, 1, 2] == FREE) == is_free
    # Another look that meets it, too, says nothing.
    after = without_measured(free(), cells, wall(size))
    assert after.state[1, 1, 2] == UNSEEN
