"""Finds the extent of the surface around a surfel from votes in its plane.

A disc that extends beyond an edge makes distances too short; a disc that ends
before the edge makes them too long. So if views show free space beside a
surfel, the edges are found as straight lines in its plane, and the disc is
fitted between them.
"""

import dataclasses as dc
from functools import cache

import numpy as np

from remosplat_drake.reconstruction.surfels.surfel_gathering import GRID

_TURNS = 12
"""Edges are tried in this many directions, spread over a right angle."""

_BAND = 0.35
"""Edges are searched for in a band through the centre. Its half width is this
fraction of the grid's half width.
"""

_MIN_VOTES = 0.3
"""Beyond an edge, there must be more than this number of votes for free space.
"""

_CELL = 2 / GRID


@dc.dataclass(frozen=True, eq=False)
class Extents:
    """Edges around n surfels.

    Attributes:
        turn: Angle of the edges' frame in the tangent plane, shape (n,) [rad].
        edge: Distance of the edge from the centre along that frame's axes x,
            -x, y, -y, shape (n, 4) [m]; negative if the centre is beyond the
            edge, inf if there is no edge.
        solid: Mean number of votes for a surface in the cells within the edges,
            shape (n,).
        free: Mean number of votes for free space in these cells, shape (n,).
    """

    turn: np.ndarray
    edge: np.ndarray
    solid: np.ndarray
    free: np.ndarray


def find_extents(
    solid: np.ndarray, free: np.ndarray, radius: np.ndarray
) -> Extents:
    """Finds the edges that best separate votes for a surface and free space.

    Args:
        solid: Votes for a surface, shape (n, GRID, GRID); see `gather_votes`.
        free: Votes for free space, shape (n, GRID, GRID).
        radius: Half the width of the grids, shape (n,) [m].
    """
    n = len(solid)
    solid = solid.reshape(n, -1).astype(np.float32)
    free = free.reshape(n, -1).astype(np.float32)
    turn, edge = np.zeros(n), np.full((n, 4), np.inf)
    torn = np.flatnonzero(free.sum(axis=1) > _MIN_VOTES)
    score = np.full(len(torn), -np.inf)
    for k in range(_TURNS):
        angle = k * np.pi / 2 / _TURNS
        found = np.stack(
            [
                _edge(solid[torn] @ profile, free[torn] @ profile)
                for profile in _profiles(angle)
            ],
            axis=1,
        )
        inside = _inside(np.full(len(torn), angle), np.minimum(found, 0.9))
        agreement = ((solid[torn] - 2 * free[torn]) * inside).sum(axis=1)
        # Of equally good directions, the first is chosen, regardless of
        # rounding.
        better = agreement > score + 1e-3
        score[better] = agreement[better]
        turn[torn[better]] = angle
        edge[torn[better]] = found[better]
    core = _inside(turn, np.minimum(edge, 0.45))
    cells = np.maximum(core.sum(axis=1), 1)
    return Extents(
        turn,
        edge * radius[:, None],
        (solid * core).sum(axis=1) / cells,
        (free * core).sum(axis=1) / cells,
    )


def fit_discs(
    extents: Extents,
    p_WK: np.ndarray,
    R_WK: np.ndarray,
    reach: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fits elliptic discs that end at the edges.

    Args:
        extents: The edges.
        p_WK: Centres, shape (n, 3) [m].
        R_WK: Tangent frames, shape (n, 3, 3).
        reach: Semi-axis of a disc without edges, shape (n,) [m]. A disc at an
            edge is a little larger, since it overlaps with fewer neighbours.

    Returns:
        Centres (n, 3) [m], orientations (n, 3, 3) and semi-axes (n, 2) [m]; an
        axis is negative if the disc is beyond the edge.
    """
    far = 1.35 * reach[:, None]
    near_edge = extents.edge < far
    across_x = near_edge[:, :2].any(axis=1)
    across_y = near_edge[:, 2:].any(axis=1)
    along_x = np.where(across_y & ~across_x, far[:, 0], reach)
    along_y = np.where(across_x & ~across_y, far[:, 0], reach)
    end = np.where(
        near_edge,
        extents.edge,
        np.stack([along_x, along_x, along_y, along_y], axis=1),
    )
    cosine, sine = np.cos(extents.turn), np.sin(extents.turn)
    x_W, y_W, z_W = R_WK.transpose(2, 0, 1)
    u_W = cosine[:, None] * x_W + sine[:, None] * y_W
    v_W = cosine[:, None] * y_W - sine[:, None] * x_W
    shift = (end[:, [0, 2]] - end[:, [1, 3]]) / 2
    center = p_WK + shift[:, :1] * u_W + shift[:, 1:] * v_W
    orientation = np.stack([u_W, v_W, z_W], axis=2)
    return center, orientation, (end[:, [0, 2]] + end[:, [1, 3]]) / 2


def _cells() -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of the cells' centres in [-1, 1], (GRID^2,) each."""
    x = (np.arange(GRID) + 0.5) * _CELL - 1
    a, b = np.meshgrid(x, x, indexing="ij")
    return a.ravel(), b.ravel()


def _axes(angle: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    """The cells' coordinates in frames turned by the angles."""
    a, b = _cells()
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * a + sine * b, cosine * b - sine * a


def _inside(turn: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Mask of the cells between the ends along x, -x, y, -y; (n, GRID^2)."""
    x, y = _axes(turn[:, None])
    inside = (x < ends[:, :1]) & (-x < ends[:, 1:2])
    return inside & (y < ends[:, 2:3]) & (-y < ends[:, 3:])


@cache
def _profiles(angle: float) -> tuple[np.ndarray, ...]:
    """Matrices from votes to profiles along x, -x, y, -y: (GRID^2, GRID).

    The votes of a cell are divided between the two bins on either side of its
    centre.
    """
    x, y = _axes(angle)
    return tuple(
        _profile(along, np.abs(across) < _BAND)
        for along, across in ((x, y), (-x, y), (y, x), (-y, x))
    )


def _profile(along: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    position = (along + 1) / _CELL - 0.5
    bins = np.arange(GRID)
    share = np.maximum(0, 1 - np.abs(position[:, None] - bins))
    return (share * chosen[:, None]).astype(np.float32)


def _edge(solid: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Where profiles change from solid to free, (n,) in [-1, 1] or inf.

    The edge is where the number of votes on the wrong side is least. The shares
    of votes in the two bins beside the edge then determine its position within
    a bin.
    """
    n = len(solid)
    start = np.zeros((n, 1))
    solid_before = np.concatenate([start, np.cumsum(solid, axis=1)], axis=1)
    free_before = np.concatenate([start, np.cumsum(free, axis=1)], axis=1)
    wrong = free_before + solid_before[:, -1:] - solid_before
    # Of equally good positions, the last is chosen, so that nothing is cut off
    # if there are no votes.
    place = GRID - wrong[:, ::-1].argmin(axis=1)
    place = np.maximum(place, 1)
    i = np.arange(n)
    beyond = free_before[:, -1] - free_before[i, place]

    def share(k: np.ndarray, default: float) -> np.ndarray:
        k = np.minimum(k, GRID - 1)
        total = solid[i, k] + free[i, k]
        return np.where(
            total > 1e-6, solid[i, k] / np.maximum(total, 1e-6), default
        )

    fine = share(place - 1, 1.0) + share(place, 0.0) - 1
    found = (place < GRID) & (beyond > _MIN_VOTES)
    return np.where(found, (place + fine) * _CELL - 1, np.inf)
