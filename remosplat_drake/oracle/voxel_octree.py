"""`VoxelOctree`: an octree of seen and unseen voxels of a grid."""

from typing import NamedTuple

import numpy as np

SEEN, UNSEEN = 0, 1
"""Kinds of voxels, as columns of `VoxelOctree.children`."""


class VoxelOctree(NamedTuple):
    """A grid of unseen and seen voxels; the outermost are unseen.

    A node of level l spans 2^l voxels along each axis; one of level 0 is a
    voxel, and the only one of the highest level is the root.

    Attributes:
        unseen: Which voxels are unseen, shape (nx, ny, nz), bool.
        children: For each node above level 0, the children with seen and with
            unseen voxels, shape (m, 2), uint8. Bit 4 a + 2 b + c is set for
            child (2 i + a, 2 j + b, 2 k + c) of node (i, j, k).
        levels: For each level, the row of its first node in `children` and the
            numbers of nodes along y and z, shape (n, 3); a level's rows are in
            C order. Level 0 has no rows.
        lower: Lower corner of the grid, shape (3,) [m].
        voxel: Edge length of a voxel [m].
    """

    unseen: np.ndarray
    children: np.ndarray
    levels: np.ndarray
    lower: np.ndarray
    voxel: float


def level_table(shape: tuple[int, ...]) -> np.ndarray:
    """Returns the `levels` of an octree over a grid.

    Args:
        shape: Number of voxels along each axis.
    """
    size = np.array(shape)
    levels, row = [(0, size[1], size[2])], 0
    while size.max() > 1:
        size = -(-size // 2)
        levels.append((row, size[1], size[2]))
        row += size.prod()
    return np.array(levels, np.int64)


def child_masks(unseen: np.ndarray) -> np.ndarray:
    """Returns the `children` of an octree over a grid.

    Args:
        unseen: Which voxels are unseen, shape (nx, ny, nz), bool.
    """
    there, rows = np.stack([~unseen, unseen], axis=-1), []
    while max(there.shape[:3]) > 1:
        odd = [(0, n % 2) for n in there.shape[:3]]
        there = np.pad(there, [*odd, (0, 0)])
        masks = np.zeros((*(n // 2 for n in there.shape[:3]), 2), np.uint8)
        for bit in range(8):
            a, b, c = bit >> 2, bit >> 1 & 1, bit & 1
            masks |= there[a::2, b::2, c::2].astype(np.uint8) << bit
        rows.append(masks.reshape(-1, 2))
        there = masks > 0
    return np.concatenate(rows)
