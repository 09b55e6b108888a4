"""One convex piece with few corners around a part of a mesh."""

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    convex_corners,
    convex_piece,
)

SLACK = 4e-4
"""How far corners that a piece does without may be outside it [m]."""

_MOST_CORNERS = 200
"""Most corners of a piece: ticks look at all."""

_MORE = 1.5
"""Factor on the slack until the corners suffice."""

_SPARE = 6e-5
"""How deep in the pieces all lies [m]: files are in micrometres, and
`standing_out` sees no less."""

_CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
"""The corners of the one around the unit ball."""


def enclosing_piece(surface: np.ndarray) -> ConvexPiece:
    """Makes a piece with few corners that holds a surface.

    The surface is thickened by the slack before corners are left out: for each
    face of the piece, what is thickened is outside by the slack at most, and so
    nothing of the surface is. The piece stands out by at most twice the slack,
    however thin or sharp the surface is.

    Args:
        surface: Triangles, shape (t, 3, 3) [m]. It may be flat, and gets a
            thickness of two `SLACK` then.
    """
    p = convex_corners(surface.reshape(-1, 3))
    cube = _CUBE @ _axes(p)
    slack = SLACK
    while True:
        thick = (p[:, None] + (slack + _SPARE) * cube).reshape(-1, 3)
        piece = convex_piece(thick, slack)
        if len(piece.vertices) <= _MOST_CORNERS:
            return piece
        slack *= _MORE


def _axes(p: np.ndarray) -> np.ndarray:
    """The link's axes or the principal ones, by the smaller box around p.

    Thickened along its own axes, a box remains one.
    """
    main = np.linalg.eigh(np.cov(p.T))[1].T
    sizes = [
        (np.ptp(p @ x.T, axis=0) + SLACK).prod() for x in (np.eye(3), main)
    ]
    return np.eye(3) if sizes[0] <= sizes[1] else main


class Pieces:
    """Convex pieces as `standing_out` asks for them.

    Attributes:
        planes: Outward normals and offsets of the faces of all pieces, normal .
            x + offset being the height above them, shape (k, 4) [m].
        first: Where each piece's planes begin, shape (n + 1,).
    """

    def __init__(self, pieces: list[ConvexPiece]):
        """Finds the planes of some pieces, at least one."""
        planes = [ConvexHull(piece.vertices).equations for piece in pieces]
        self.planes = np.vstack(planes)
        self.first = np.cumsum([0, *map(len, planes)])

    def outside_each(self, p: np.ndarray) -> np.ndarray:
        """Computes the greatest height of points above each piece's planes.

        Args:
            p: Points, shape (n, 3) [m].

        Returns:
            Shape (n, k) [m], negative inside; less than the distance where an
            edge or a corner is nearest.
        """
        heights = p @ self.planes[:, :3].T + self.planes[:, 3]
        return np.maximum.reduceat(heights, self.first[:-1], axis=1)
