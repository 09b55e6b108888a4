"""Makes a convex piece with few corners around a part of a mesh."""

import dataclasses as dc
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    convex_corners,
    convex_piece,
)

SLACK = 4e-4
"""A piece may omit corners of its thickened surface up to this far outside it
[m]."""

_MOST_CORNERS = 200
"""A piece has at most this many corners, because a tick may visit all of them.
"""

_MORE = 1.5
"""The slack is multiplied by this factor until a piece has few enough corners.
"""

_SPARE = 6e-5
"""The surface must be at least this deep inside the pieces [m], because files
are rounded to micrometres, and `standing_out` has a finite resolution."""

_CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
"""The corners of the cube around the unit ball."""


@dc.dataclass(frozen=True, eq=False)
class Enclosed:
    """A surface, and the convex piece that encloses it.

    Attributes:
        surface: Triangles, shape (t, 3, 3) [m].
        piece: The piece, from `enclosing_piece`.
    """

    surface: np.ndarray
    piece: ConvexPiece

    @staticmethod
    def make(surface: np.ndarray) -> "Enclosed":
        """Encloses a surface.

        Args:
            surface: Triangles, shape (t, 3, 3) [m].
        """
        return Enclosed(surface, enclosing_piece(surface))


def enclosing_piece(surface: np.ndarray) -> ConvexPiece:
    """Makes a convex piece with few corners that encloses a surface.

    The surface is first thickened by the slack, then corners are omitted. The
    thickened surface is outside each face of the piece by at most the slack, so
    the surface itself is inside. The piece protrudes by at most twice the
    slack, even if the surface is thin or sharp.

    Args:
        surface: Triangles, shape (t, 3, 3) [m]. A flat surface gets a thickness
            of two `SLACK`.
    """
    p = convex_corners(surface.reshape(-1, 3))
    cube = _CUBE @ _axes(p)
    slack = SLACK
    while True:
        thick = (p[:, None] + (slack + _SPARE) * cube).reshape(-1, 3)
        piece = convex_piece(thick, slack, _MOST_CORNERS)
        if len(piece.vertices) <= _MOST_CORNERS:
            return piece
        slack *= _MORE


def _axes(p: np.ndarray) -> np.ndarray:
    """Returns the axes of the smaller box: the link's or the principal axes.

    The box encloses the points p. A box that is thickened along its own axes
    remains a box.
    """
    main = np.linalg.eigh(np.cov(p.T))[1].T
    sizes = [
        (np.ptp(p @ x.T, axis=0) + SLACK).prod() for x in (np.eye(3), main)
    ]
    return np.eye(3) if sizes[0] <= sizes[1] else main


class Pieces:
    """Convex pieces as planes, in the form that `standing_out` requires.

    Attributes:
        planes: Outward normals and offsets of the faces of all pieces, with
            normal . x + offset as the height above the face, shape (k, 4) [m].
        first: Index of each piece's first plane; the last entry is the number
            of planes, shape (n + 1,).
    """

    def __init__(self, pieces: list[ConvexPiece]):
        """Computes the planes of one or more pieces."""
        planes = [ConvexHull(piece.vertices).equations for piece in pieces]
        self.planes = np.vstack(planes)
        self.first = np.cumsum([0, *map(len, planes)])

    def outside_each(self, p: np.ndarray) -> np.ndarray:
        """Computes the greatest height of points above each piece's planes.

        Args:
            p: Points, shape (n, 3) [m].

        Returns:
            The heights, shape (n, k) [m], negative inside. They are smaller
            than the distance if an edge or a corner of the piece is nearest.
        """
        heights = p @ self.planes[:, :3].T + self.planes[:, 3]
        return np.maximum.reduceat(heights, self.first[:-1], axis=1)
