"""`VoxelOctree`: an octree over the seen and unseen voxels of a grid."""

from typing import NamedTuple

import numpy as np

SEEN, UNSEEN = 0, 1
"""Kinds of voxels, which are the columns of `VoxelOctree.children`."""


class VoxelOctree(NamedTuple):
    """An octree over a grid of voxels; the outermost voxels are unseen.

    A node of level l spans 2^l voxels along each axis. The nodes of level 0 are
    the voxels, and the only node of the highest level is the root.

    Attributes:
        unseen: Whether each voxel is unseen, shape (nx, ny, nz), bool.
        children: For each node above level 0, two bit masks of its children,
            shape (m, 2), uint8: those that contain seen voxels, and those that
            contain unseen voxels. Child (2 i + a, 2 j + b, 2 k + c) of node (i,
            j, k) has bit 4 a + 2 b + c.
        levels: For each level, the row of its first node in `children`, and the
            numbers of its nodes along y and z, shape (n, 3). The rows of a
            level are in C order. Level 0 has no rows in `children`.
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
        unseen: Whether each voxel is unseen, shape (nx, ny, nz), bool.
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
