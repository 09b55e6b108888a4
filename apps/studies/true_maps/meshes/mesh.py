"""`Mesh`: triangles in space, and the basic shapes of all objects."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform


@dc.dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in a frame W.

    Attributes:
        p_WV: Vertices, shape (n, 3) [m].
        triangles: Indices of the corners, shape (m, 3).
    """

    p_WV: np.ndarray
    triangles: np.ndarray

    def moved(self, X_FW: RigidTransform) -> "Mesh":
        """Returns the mesh in another frame F."""
        return dc.replace(self, p_WV=X_FW.multiply(self.p_WV.T).T)

    def shifted(self, p_FW: Sequence[float] | np.ndarray) -> "Mesh":
        """Returns the mesh moved by a vector (3,) [m]."""
        return dc.replace(self, p_WV=self.p_WV + np.asarray(p_FW))


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Returns all triangles of meshes as one mesh."""
    starts = np.cumsum([0, *(len(mesh.p_WV) for mesh in meshes[:-1])])
    return Mesh(
        np.concatenate([mesh.p_WV for mesh in meshes]),
        np.concatenate(
            [
                mesh.triangles + start
                for mesh, start in zip(meshes, starts, strict=True)
            ]
        ),
    )


def box(lower: Sequence[float], upper: Sequence[float]) -> Mesh:
    """Makes an axis-aligned box from its corners [m]."""
    low, high = np.asarray(lower, float), np.asarray(upper, float)
    corners = np.array(list(np.ndindex(2, 2, 2)))
    sides = np.array(
        [
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ]
    )
    triangles = np.concatenate([sides[:, [0, 1, 2]], sides[:, [0, 2, 3]]])
    return Mesh(low + corners * (high - low), triangles)


def sheet(p_W: np.ndarray) -> Mesh:
    """Makes a surface without thickness from a grid of points (r, c, 3)."""
    return Mesh(p_W.reshape(-1, 3), _grid_triangles(*p_W.shape[:2]))


def tube(
    p_WP: np.ndarray,
    radius: float | Sequence[float] | np.ndarray,
    sides: int = 16,
) -> Mesh:
    """Sweeps a regular polygon along a curve, and closes both ends.

    Args:
        p_WP: Points of the curve, shape (n, 3) [m].
        radius: Distance of the polygon's corners from the curve [m], one or
            one for each point.
        sides: Number of the polygon's corners.
    """
    p_WP = np.asarray(p_WP, float)
    radius = np.broadcast_to(radius, len(p_WP))
    along = np.gradient(p_WP, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = _carried(along)
    x, y = _polygon(sides)[..., None]
    ring = x * across[:, None] + y * np.cross(along, across)[:, None]
    return _closed(p_WP[:, None] + radius[:, None, None] * ring)


def upright(
    heights: Sequence[float], radius: float | Sequence[float], sides: int = 24
) -> Mesh:
    """Makes a surface of revolution about the z axis, closed at both ends.

    Args:
        heights: Heights of its rings [m]; equal ones make a step.
        radius: Radius of all rings or of each [m].
        sides: Number of its corners all round.
    """
    z, r = np.broadcast_arrays(heights, radius)
    x, y = _polygon(sides)
    rings = [np.outer(r, x), np.outer(r, y), np.outer(z, np.ones(sides))]
    return _closed(np.stack(rings, axis=-1))


def curve(
    points: Sequence[Sequence[float] | np.ndarray], count: int = 40
) -> np.ndarray:
    """Rounds off a polygon: a Bézier curve, shape (count, 3) [m]."""
    p = np.asarray(points, float)[:, None]
    s = np.linspace(0, 1, count)[:, None]
    while len(p) > 1:
        p = (1 - s) * p[:-1] + s * p[1:]
    return p[0]


def _polygon(sides: int) -> np.ndarray:
    """Corners of a regular polygon on the unit circle, (2, sides)."""
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.array([np.cos(angle), np.sin(angle)])


def _closed(rings: np.ndarray) -> Mesh:
    """The surface through polygons (n, sides, 3), with a lid on each end."""
    count, sides = rings.shape[:2]
    row, column = np.divmod(_grid_triangles(count, sides + 1), sides + 1)
    around = np.arange(sides)
    first = np.stack([np.roll(around, -1), around], axis=1)
    last = first[:, ::-1] + (count - 1) * sides
    lids = [
        np.column_stack([edge, np.full(sides, count * sides + end)])
        for end, edge in enumerate((first, last))
    ]
    return Mesh(
        np.concatenate([rings.reshape(-1, 3), rings[[0, -1]].mean(axis=1)]),
        np.concatenate([row * sides + column % sides, *lids]),
    )


def _carried(along: np.ndarray) -> np.ndarray:
    """Unit vectors across a curve that do not turn about it, (n, 3)."""
    first = np.eye(3)[np.abs(along[0]).argmin()]
    across = [first]
    for direction in along:
        vector = across[-1] - direction * (direction @ across[-1])
        across.append(vector / np.linalg.norm(vector))
    return np.array(across[1:])


def _grid_triangles(rows: int, columns: int) -> np.ndarray:
    """Two triangles for each cell of a grid of points, (m, 3)."""
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    c, d = index[1:, :-1].ravel(), index[1:, 1:].ravel()
    return np.concatenate(
        [np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)]
    )
