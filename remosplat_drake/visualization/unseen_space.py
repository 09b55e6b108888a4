"""`frontier_mesh`: where what the cameras saw ends and the unknown begins."""

import numpy as np

from remosplat_drake.reconstruction.coverage import FREE, UNSEEN, Coverage

# Corners of a voxel's face at its lower end along an axis, counterclockwise
# seen from below, where the normal points.
_CORNERS = np.array(
    [
        [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]],
        [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]],
        [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]],
    ]
)


def frontier_mesh(
    coverage: Coverage, layer: int
) -> tuple[np.ndarray, np.ndarray]:
    """The faces between free and unseen voxels in one layer of the grid.

    They look into the free space: drawn from that side only, the walls
    between an onlooker outside and the scene do not hide it. The edge of the
    grid is a wall, too, but not its floor. Unseen space behind a surface is
    no frontier: nobody could have seen it.

    Args:
        coverage: What was seen.
        layer: Index of the voxels along z.

    Returns:
        Vertices (n, 3) in W [m] and faces (m, 3), outward normals by the
        right hand; empty where all is seen or nothing.
    """
    free = coverage.state[:, :, layer] == FREE
    if not free.any():
        return np.zeros((0, 3)), np.zeros((0, 3), np.int32)
    quads = []
    for (axis, side), unseen in _neighbours(coverage.state, layer).items():
        voxels = np.argwhere(free & unseen)
        quads.append(_quads(voxels, axis, side))
    corners = np.concatenate(quads).reshape(-1, 3)
    corners[:, 2] += layer
    vertices = coverage.lower + coverage.voxel * corners
    fan = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    first = np.arange(0, len(vertices), 4, dtype=np.int32)
    return vertices, (first[:, None, None] + fan).reshape(-1, 3)


def _neighbours(
    state: np.ndarray, layer: int
) -> dict[tuple[int, int], np.ndarray]:
    """Whether the six neighbours of a layer's voxels are unseen.

    Returns:
        By axis and side (-1 or 1), shape (nx, ny).
    """
    nx, ny, nz = state.shape
    here = np.ones((nx + 2, ny + 2), bool)
    here[1:-1, 1:-1] = state[:, :, layer] == UNSEEN
    top, floor = np.ones((nx, ny), bool), np.zeros((nx, ny), bool)
    return {
        (0, -1): here[:-2, 1:-1],
        (0, 1): here[2:, 1:-1],
        (1, -1): here[1:-1, :-2],
        (1, 1): here[1:-1, 2:],
        (2, -1): state[:, :, layer - 1] == UNSEEN if layer else floor,
        (2, 1): state[:, :, layer + 1] == UNSEEN if layer + 1 < nz else top,
    }


def _quads(voxels: np.ndarray, axis: int, side: int) -> np.ndarray:
    """Corners of those faces of voxels, looking into them; (n, 4, 3)."""
    corners = _CORNERS[axis].copy()
    if side < 0:
        # At the lower end of a voxel it looks up, at the upper end down.
        corners = corners[::-1]
    else:
        corners[:, axis] += 1
    at_floor = np.column_stack([voxels, np.zeros(len(voxels), int)])
    return at_floor[:, None] + corners
