"""Computes and draws the boundary between seen and unseen space."""

from collections.abc import Iterator
from itertools import product

import numpy as np
from pydrake.geometry import Meshcat, Rgba
from pydrake.math import RigidTransform

from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.toggle import on_off

UNSEEN_SPACE = f"{ROOT}/map/unseen"

_STEP = 2.0**-12  # Between places of vertices [m].
_VEIL = Rgba(0.33, 0.38, 0.62, 0.16)

# Corners of a voxel's lower face along an axis, counterclockwise as seen from
# below, so that the normal points down.
_CORNERS = np.array(
    [
        [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]],
        [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]],
        [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]],
    ]
)

# Vectors from a corner of a voxel to the centres of the eight voxels around it
# [voxels].
_AROUND = np.array(list(product((-1.5, -0.5, 0.5, 1.5), repeat=3)))
_SQUARES = 80.0  # Sum of the squares of either of their coordinates.


def show_unseen_space(
    page: MeshcatPage,
    coverage: Coverage,
    X_WG: RigidTransform,
    *,
    shown: bool,
) -> None:
    """Draws the boundary of the seen space, and adds a button that hides it.

    Args:
        page: The page to draw on.
        coverage: Voxel grid of the seen space, in the splat's frame G.
        X_WG: Pose of G in W.
        shown: Whether the boundary is visible at first.
    """
    page.meshcat.SetTransform(UNSEEN_SPACE, X_WG)
    for _ in draw_layers(page.meshcat, coverage):
        pass
    add_unseen_toggle(page, shown=shown)


def add_unseen_toggle(page: MeshcatPage, *, shown: bool) -> None:
    """Adds the button that shows or hides unseen space.

    Args:
        page: The page that gets the button.
        shown: Whether unseen space is visible at first.
    """
    page.add_toggle(on_off("Unseen space", "4", UNSEEN_SPACE, shown=shown))


def draw_layers(meshcat: Meshcat, coverage: Coverage) -> Iterator[str | None]:
    """Draws one layer of the boundary per step.

    Args:
        meshcat: The Meshcat server.
        coverage: The voxel grid of the seen space.

    Yields:
        The path of the drawn layer, or None if the layer has no boundary.
    """
    for layer in range(coverage.state.shape[2]):
        vertices, faces = frontier_mesh(coverage, layer)
        path = f"{UNSEEN_SPACE}/{layer}" if len(faces) else None
        if path is not None:
            vertices = smoothed(vertices, coverage, layer)
            vertices, faces = merged(vertices, faces)
            # Faces are visible only from their front side.
            meshcat.SetTriangleMesh(
                path,
                vertices.T,
                faces.T,
                _VEIL,
                side=Meshcat.SideOfFaceToRender.kFrontSide,
            )
            meshcat.SetProperty(f"{path}/<object>", "castShadow", False)
        yield path


def frontier_mesh(
    coverage: Coverage, layer: int
) -> tuple[np.ndarray, np.ndarray]:
    """Makes a mesh of the faces between free and unseen voxels of a layer.

    The normals of the faces point into the free space, and faces are visible
    only from that side. Faces between an outside viewer and the scene therefore
    do not hide the scene. The sides of the grid have faces, too; its floor has
    none. Unseen space behind a surface has no faces, since no camera could have
    seen it.

    Args:
        coverage: The voxel grid of the seen space.
        layer: Index of the layer along z.

    Returns:
        Vertices, shape (n, 3) [m], and faces, shape (m, 3), whose normals
        follow the right-hand rule. Both are empty if the layer is seen
        completely or not at all.
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


def merged(
    vertices: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Merges vertices at the same position.

    Args:
        vertices: Vertices, less than 200 m apart, shape (n, 3) [m].
        faces: Indices of the vertices, shape (m, 3).

    Returns:
        The remaining vertices, rounded to a quarter of a millimetre, and the
        faces between them.
    """
    steps = np.rint(vertices / _STEP).astype(np.int64)
    steps -= steps.min(axis=0)
    # A position is encoded as one number, which is sorted faster than three.
    key = steps @ np.array([1, 1 << 20, 1 << 40])
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    rounded = _STEP * np.rint(vertices[first] / _STEP)
    return rounded, index[faces].astype(np.int32)


def smoothed(
    vertices: np.ndarray, coverage: Coverage, layer: int
) -> np.ndarray:
    """Smooths the boundary of unseen space, so that its steps become slopes.

    Each vertex moves onto the plane that best separates the free voxels around
    it from all other voxels around it. The motion is at most a voxel along each
    axis. It depends only on these voxels, so that adjacent layers remain
    connected.

    Args:
        vertices: Vertices of a `frontier_mesh`, shape (n, 3) [m].
        coverage: The voxel grid that the mesh was made of.
        layer: Index of the layer that the mesh was made of.

    Returns:
        The moved vertices, shape (n, 3) [m].
    """
    free = _free_around(coverage.state, layer)
    corners = np.round((vertices - coverage.lower) / coverage.voxel).astype(int)
    i, j, k = (corners - [0, 0, layer] + 2).T
    # Neighbouring faces share corners.
    number, same = np.unique(
        np.ravel_multi_index((i, j, k), free.shape), return_inverse=True
    )
    strides = np.array([free.shape[1] * free.shape[2], free.shape[2], 1])
    around = number[:, None] + np.floor(_AROUND).astype(int) @ strides
    sign = np.where(free.ravel()[around], 1.0, -1.0)
    slope = sign @ _AROUND / _SQUARES
    # The vertex moves to the zero of the linear function that fits the voxels
    # best.
    steepness = np.maximum((slope**2).sum(axis=1), 1e-9)
    step = -(sign.mean(axis=1) / steepness)[:, None] * slope
    return vertices + coverage.voxel * np.clip(step, -1.0, 1.0)[same]


def _free_around(state: np.ndarray, layer: int) -> np.ndarray:
    """Returns which voxels near a layer are free, (nx + 4, ny + 4, 5).

    The array contains all voxels up to two voxels away from the layer. Below
    the grid, the grid's lowest layer is repeated. Beyond all other sides of the
    grid, no voxel is free.
    """
    layers = np.arange(layer - 2, layer + 3)
    last = state.shape[2] - 1
    free = state[:, :, np.clip(layers, 0, last)] == FREE
    free &= layers <= last
    return np.pad(free, ((2, 2), (2, 2), (0, 0)))


def _neighbours(
    state: np.ndarray, layer: int
) -> dict[tuple[int, int], np.ndarray]:
    """Returns whether the six neighbours of each voxel of a layer are unseen.

    Returns:
        Arrays of shape (nx, ny), by axis and side (-1 or 1).
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
    """Returns the corners, (n, 4, 3), of voxels' faces that point inward."""
    corners = _CORNERS[axis].copy()
    if side < 0:
        # A lower face of a voxel points up, an upper face down.
        corners = corners[::-1]
    else:
        corners[:, axis] += 1
    at_floor = np.column_stack([voxels, np.zeros(len(voxels), int)])
    return at_floor[:, None] + corners
