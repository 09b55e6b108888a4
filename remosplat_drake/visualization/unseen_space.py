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
    free, unseen = (
        _with_neighbours(coverage.state, layer, state, outside)
        for state, outside in ((FREE, False), (UNSEEN, True))
    )
    here = (slice(1, -1),) * 3
    quads = []
    for axis in range(3):
        for side in (-1, 1):
            faces = free[here] & np.roll(unseen, -side, axis)[here]
            quads.append(_quads(np.argwhere(faces), axis, side))
    corners = np.concatenate(quads).reshape(-1, 3) + [0, 0, layer]
    vertices = coverage.lower + coverage.voxel * corners
    fan = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    first = np.arange(0, len(vertices), 4, dtype=np.int32)
    return vertices, (first[:, None, None] + fan).reshape(-1, 3)


def _with_neighbours(
    state: np.ndarray, layer: int, wanted: int, outside: bool
) -> np.ndarray:
    """Whether the voxels in and around a layer are in a state."""
    nx, ny, nz = state.shape
    shown = np.full((nx + 2, ny + 2, 3), outside)
    # Below the grid is the floor, which is neither.
    shown[:, :, 0] = outside and layer > 0
    first, end = max(layer - 1, 0), min(layer + 2, nz)
    place = slice(first - layer + 1, end - layer + 1)
    shown[1:-1, 1:-1, place] = state[:, :, first:end] == wanted
    return shown


def _quads(voxels: np.ndarray, axis: int, side: int) -> np.ndarray:
    """Corners of faces of voxels that look into them, (n, 4, 3)."""
    corners = _CORNERS[axis]
    # At its lower end a face looks up, at its upper end down.
    corners = (
        corners[::-1] if side < 0 else corners + np.eye(3, dtype=int)[axis]
    )
    return voxels[:, None] + corners
