"""Classifies space as free, surface or unseen by a capture.

Unseen space counts as solid for the robot. A voxel is seen if views show all of
it as free. It is also seen if the splat's discs separate its free part from its
unknown part, because a robot in the free part then reaches a disc before
unknown space. For this test, voxels at surfaces are divided into cells. A cell
is a frontier (Yamauchi, 1997) if it is not free, is beside a free cell, and has
no disc. A voxel that contains a frontier counts as unseen. Space with a
measured point is not free, even if the measured object is thin; see
`measured_cells`.
"""

import dataclasses as dc
from itertools import product

import numpy as np
from scipy.ndimage import binary_dilation, label

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_cells import (
    CELLS,
    MARGIN,
    measured_cells,
    seen_finely,
    without_measured,
)
from remosplat_drake.reconstruction.whole_looks import count_whole_looks
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.signals.coverage import (
    FREE,
    SURFACE,
    UNSEEN,
    Coverage,
    grid_shape,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

VOXEL = 0.04
"""Usual edge length of a voxel [m]."""

_ENOUGH_VIEWS = 2
"""A cell beside a surface is free only if this many views show it as free."""

_OPAQUE = 0.1
"""A disc covers a cell only if it has at least this opacity; oracles ignore
less opaque discs.
"""

_BEYOND = 0.2
"""On each of its sides, the box may leave out this percentage of the surfaces.
"""

_FARTHEST = 3.0
"""A robot is assumed to be at most this far from its workspace [m]."""

_MOST_VOXELS = 4e6
"""There are at most this many voxels, because the computation with more voxels
takes over a minute.
"""

_MOST_RINGS = 200
"""A disc is represented by points on at most this many rings, so that very
large discs do not fill the memory.
"""

_BLOCK = np.ones((3, 3, 3), bool)
"""Mask of a voxel and its 26 neighbours, for morphological operations."""

_AROUND = np.array(list(product((-1, 0, 1), repeat=3)))
_SIDES = _AROUND[np.abs(_AROUND).sum(axis=1) == 1]


@dc.dataclass(frozen=True, eq=False)
class _Cells:
    """The cells of those voxels that hold discs or border on them.

    Attributes:
        slot: Index of each voxel among the divided voxels, -1 for undivided
            voxels, shape (nx, ny, nz), int32.
        voxels: Indices of the divided voxels, shape (n, 3).
        covered: Mask of the cells that are at discs, shape (n, m, m, m), bool.
        free: Mask of the cells that are free, shape (n, m, m, m), bool.
    """

    slot: np.ndarray
    voxels: np.ndarray
    covered: np.ndarray
    free: np.ndarray


def seen_box(
    capture: Capture, workspace: Workspace, voxel: float = VOXEL
) -> tuple[np.ndarray, np.ndarray, float]:
    """Returns a box around the space that a capture may have seen.

    Seen space extends from the cameras to the surfaces, and a robot works
    within some metres of its workspace.

    Args:
        capture: Posed RGB-D images.
        workspace: Box in which the robot works.
        voxel: Wanted edge length of a voxel [m].

    Returns:
        Lower and upper corner, shape (3,) each [m], and the edge length of
        voxels [m]. It is larger than `voxel` if there would be too many voxels.
    """
    seen = Workspace.of_capture(capture, beyond=_BEYOND)
    p_WC = capture.X_WC[:, :3, 3]
    lower = np.minimum(seen.lower, p_WC.min(axis=0)) - voxel
    upper = np.maximum(seen.upper, p_WC.max(axis=0)) + voxel
    lower = np.maximum(lower, workspace.lower - _FARTHEST)
    upper = np.minimum(upper, workspace.upper + _FARTHEST)
    voxels = float(np.prod((upper - lower) / voxel))
    return lower, upper, voxel * max(1.0, voxels / _MOST_VOXELS) ** (1 / 3)


def find_seen_space(
    capture: Capture,
    splat_W: GaussianSplat,
    lower: np.ndarray,
    upper: np.ndarray,
    voxel: float = VOXEL,
    measured: np.ndarray | None = None,
) -> Coverage:
    """Classifies the voxels of a box as surface, free or unseen.

    A voxel is free if a view shows all of it as free. It is surface if discs
    separate its free part from its unseen part. All other voxels are unseen,
    including the inside of objects. Beside surfaces, where depth images have
    most errors, several views must agree. In cells with measured points, only
    views with closely spaced pixels count.

    Args:
        capture: Posed RGB-D images.
        splat_W: The surfaces of the robot's map, in W.
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].
        measured: Cells that contain measured points, as `measured_cells`
            returns them; None: those of the capture.
    """
    lower = np.asarray(lower, float)
    if measured is None:
        measured = measured_cells(capture, lower, upper, voxel)
    shape = np.array(grid_shape(lower, upper, voxel))
    everywhere = np.indices(tuple(shape.tolist())).reshape(3, -1).T
    looks = _looks(capture, lower, everywhere, voxel, 1)
    state = np.where(looks > 0, FREE, UNSEEN).astype(np.uint8).reshape(shape)
    covered = _covered_cells(splat_W, lower, voxel / CELLS, shape * CELLS)
    cells = _divide(covered, state)
    inner = np.indices((CELLS,) * 3).reshape(3, -1).T
    parts = (cells.voxels[:, None] * CELLS + inner).reshape(-1, 3)
    looks = _looks(capture, lower, parts, voxel / CELLS, _ENOUGH_VIEWS)
    free = looks >= _ENOUGH_VIEWS
    doubted = np.flatnonzero(free & _is_among(parts, measured, shape * CELLS))
    free[doubted] = seen_finely(capture, lower, parts[doubted], voxel / CELLS)
    cells.free[:] = free.reshape(cells.free.shape)
    open_sided = _frontier(cells, state).any(axis=(1, 2, 3))
    state[tuple(cells.voxels.T)] = np.where(open_sided, UNSEEN, SURFACE)
    state[_floats(state)] = FREE
    return without_measured(Coverage(lower, voxel, state), measured, capture)


def _looks(
    capture: Capture,
    lower: np.ndarray,
    cubes: np.ndarray,
    edge: float,
    enough: int,
) -> np.ndarray:
    """Number of views that show each cube of a grid as free, (n,)."""
    corners = lower + edge * cubes
    return count_whole_looks(
        capture, corners, edge, margin=MARGIN, enough=enough
    )


def _is_among(
    cells: np.ndarray, others: np.ndarray, shape: np.ndarray
) -> np.ndarray:
    """Mask of the cells (n, 3) that are among the cells (m, 3), shape (n,)."""
    return np.isin(
        np.ravel_multi_index(tuple(cells.T), shape),
        np.ravel_multi_index(tuple(others.T), shape),
    )


def _floats(state: np.ndarray) -> np.ndarray:
    """Returns a mask of unseen voxels that only free voxels surround.

    A solid in such voxels would float in the air, so they are gaps between
    views.
    """
    pieces = np.zeros(state.shape, np.int32)
    count = int(label(state == UNSEEN, _BLOCK, pieces))  # pyright: ignore
    held = np.zeros(count + 1, bool)
    held[0] = True
    # A connected piece is supported if it is at the box's edge or at a surface.
    held_there = np.pad(state == SURFACE, 1, constant_values=True)
    held_there = np.asarray(binary_dilation(held_there, _BLOCK), bool)
    held_there = held_there[1:-1, 1:-1, 1:-1]
    held[pieces[held_there]] = True
    return ~held[pieces]


def _covered_cells(
    splat_W: GaussianSplat, lower: np.ndarray, cell: float, shape: np.ndarray
) -> np.ndarray:
    """Indices of the cells in which discs are, and of their neighbours."""
    opaque = splat_W.select(splat_W.opacities >= _OPAQUE)
    p_W = _points_on(opaque, cell / 2)
    covered = np.zeros(shape, bool)
    index = np.floor((p_W - lower) / cell)
    # Neighbours are marked, too, so cells just outside the box are needed.
    index = index[((index >= -1) & (index <= shape)).all(axis=1)].astype(int)
    flat = np.unique(np.ravel_multi_index(tuple((index + 1).T), shape + 2))
    index = np.stack(np.unravel_index(flat, shape + 2), axis=1) - 1
    for step in _AROUND:
        at = index + step
        at = at[((at >= 0) & (at < shape)).all(axis=1)]
        covered[tuple(at.T)] = True
    return np.argwhere(covered)


def _points_on(splat_W: GaussianSplat, spacing: float) -> np.ndarray:
    """Points on the two widest axes' ellipses, one sigma wide, (n, 3)."""
    widest = np.argsort(-splat_W.scales, axis=1, kind="stable")[:, :2]
    scales = np.take_along_axis(splat_W.scales, widest, axis=1)
    axes = np.take_along_axis(splat_W.R_GK, widest[:, None], axis=2) * (
        scales[:, None].astype(float)
    )
    rings = np.ceil(scales.max(axis=1, initial=0) / spacing).astype(int)
    rings = np.clip(rings, 1, _MOST_RINGS)
    points = [np.zeros((0, 3))]
    for n in np.unique(rings):
        step = np.arange(-n, n + 1) / n
        ab = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
        ab = ab[np.linalg.norm(ab, axis=1) <= 1]
        of = rings == n
        p_W = splat_W.p_GK[of][:, None] + np.einsum("nij,kj->nki", axes[of], ab)
        points.append(p_W.reshape(-1, 3))
    return np.concatenate(points)


def _divide(covered: np.ndarray, state: np.ndarray) -> _Cells:
    """Divides voxels with covered cells into cells, none of which is free."""
    parent = covered // CELLS
    flat = np.ravel_multi_index(tuple(parent.T), state.shape)
    divided, of = np.unique(flat, return_inverse=True)
    slot = np.full(state.shape, -1, np.int32)
    slot.flat[divided] = np.arange(len(divided))
    marks = np.zeros((len(divided), *(CELLS,) * 3), bool)
    marks[of, *(covered % CELLS).T] = True
    voxels = np.stack(np.unravel_index(divided, state.shape), axis=1)
    return _Cells(slot, voxels, marks, np.zeros_like(marks))


def _frontier(cells: _Cells, state: np.ndarray) -> np.ndarray:
    """Marks cells beside a free one that are neither free nor covered."""
    beside_free = np.zeros_like(cells.free)
    m = CELLS
    inner = np.indices((m, m, m)).reshape(3, -1).T
    for side in _SIDES:
        # The voxel of each cell's neighbour, and the neighbour's index in it.
        at = inner + side
        step, place = at // m, at % m
        neighbour = cells.voxels[:, None] + step
        within = ((neighbour >= 0) & (neighbour < state.shape)).all(axis=2)
        index = tuple(np.where(within[..., None], neighbour, 0).T)
        slot = cells.slot[index].T
        free = np.where(
            slot >= 0,
            cells.free[slot, *place.T],
            state[index].T == FREE,
        )
        beside_free |= (free & within).reshape(beside_free.shape)
    return beside_free & ~cells.free & ~cells.covered
