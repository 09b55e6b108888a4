"""The boundary between seen and unseen space, and how it is drawn."""

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

# Corners of a voxel's face at its lower end along an axis, counterclockwise
# seen from below, where the normal points.
_CORNERS = np.array(
    [
        [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]],
        [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]],
        [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]],
    ]
)

# Centres of the voxels around a corner of the grid, from it, in voxels.
_AROUND = np.array(list(product((-1.5, -0.5, 0.5, 1.5), repeat=3)))
_SQUARES = 80.0  # Sum of the squares of either of their coordinates.


def show_unseen_space(
    page: MeshcatPage,
    coverage: Coverage,
    X_WG: RigidTransform,
    *,
    shown: bool,
) -> None:
    """Draws the boundary of the space that a capture has seen, with a button.

    Args:
        page: The page to draw on.
        coverage: What was seen, in the splat's frame G.
        X_WG: Pose of G in W.
        shown: Whether it is visible to begin with.
    """
    page.meshcat.SetTransform(UNSEEN_SPACE, X_WG)
    for _ in draw_layers(page.meshcat, coverage):
        pass
    add_unseen_toggle(page, shown=shown)


def add_unseen_toggle(page: MeshcatPage, *, shown: bool) -> None:
    """Adds the button that shows or hides unseen space.

    Args:
        page: The page that gets the button.
        shown: Whether unseen space is visible to begin with.
    """
    page.add_toggle(on_off("Unseen space", "4", UNSEEN_SPACE, shown=shown))


def draw_layers(meshcat: Meshcat, coverage: Coverage) -> Iterator[str | None]:
    """Draws one layer of the boundary a step.

    Args:
        meshcat: What it is drawn on.
        coverage: The voxel grid of what was seen.

    Yields:
        The path of the layer; None for one without a boundary.
    """
    for layer in range(coverage.state.shape[2]):
        vertices, faces = frontier_mesh(coverage, layer)
        path = f"{UNSEEN_SPACE}/{layer}" if len(faces) else None
        if path is not None:
            vertices = smoothed(vertices, coverage, layer)
            vertices, faces = merged(vertices, faces)
            # What an onlooker would see from behind is left out.
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

    They look into the free space: drawn from that side only, the walls
    between an onlooker outside and the scene do not hide it. The edge of the
    grid is a wall, too, but not its floor. Unseen space behind a surface is
    no frontier: it could not have been seen.

    Args:
        coverage: The voxel grid of what was seen.
        layer: Index of the layer along z.

    Returns:
        Vertices in W, shape (n, 3) [m], and faces, shape (m, 3), whose
        normals point outward by the right-hand rule; empty where all is seen
        or nothing.
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
    """Joins corners of faces that are at the same place.

    Args:
        vertices: Vertices, less than 200 m apart, shape (n, 3) [m].
        faces: Indices of the vertices, shape (m, 3).

    Returns:
        The vertices that are left, rounded to a quarter of a millimetre, and
        the faces between them.
    """
    steps = np.rint(vertices / _STEP).astype(np.int64)
    steps -= steps.min(axis=0)
    # One number for a place is sorted faster than three.
    key = steps @ np.array([1, 1 << 20, 1 << 40])
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    rounded = _STEP * np.rint(vertices[first] / _STEP)
    return rounded, index[faces].astype(np.int32)


def smoothed(
    vertices: np.ndarray, coverage: Coverage, layer: int
) -> np.ndarray:
    """Moves corners of voxels onto the plane that fits what is around them.

    Steps become slopes. Each corner moves by itself, by at most a voxel along
    each axis, so that layers stay joined.

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
    # To where the linear function that fits best is zero.
    steepness = np.maximum((slope**2).sum(axis=1), 1e-9)
    step = -(sign.mean(axis=1) / steepness)[:, None] * slope
    return vertices + coverage.voxel * np.clip(step, -1.0, 1.0)[same]


def _free_around(state: np.ndarray, layer: int) -> np.ndarray:
    """Which voxels up to two from a layer are free, (nx + 4, ny + 4, 5).

    The floor continues below; beyond the other ends of the grid is nothing.
    """
    layers = np.arange(layer - 2, layer + 3)
    last = state.shape[2] - 1
    free = state[:, :, np.clip(layers, 0, last)] == FREE
    free &= layers <= last
    return np.pad(free, ((2, 2), (2, 2), (0, 0)))


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
