"""One convex piece with few corners around a part of a mesh."""

import numpy as np
from scipy.spatial import ConvexHull

from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    convex_corners,
    convex_piece,
    stretched,
)

SLACK = 5e-4
"""How far corners that a piece does without may be outside it [m]. Pieces are
stretched by what this takes, so that they enclose all in the end."""

_MOST_CORNERS = 200
"""Most corners of a piece: ticks look at all."""

_SPARE = 6e-5
"""How deep in the pieces all lies [m]: files are in micrometres, and
`standing_out` sees no less."""

_MOST_GROWTH = 3 * SLACK
"""How far a piece may stand out of the hull before it gets layers [m]: the edge
of a wedge has to be stretched far to hold a point beside it."""


def enclosing_piece(surface: np.ndarray) -> ConvexPiece:
    """Makes a piece with few corners that holds a surface.

    Args:
        surface: Triangles, shape (t, 3, 3) [m]. A flat one gets a thickness of
            two `SLACK`.
    """
    p = convex_corners(surface.reshape(-1, 3))
    axes = np.linalg.eigh(np.cov(p.T))[1].T
    thin = [axis for axis in axes if np.ptp(p @ axis) < 2 * SLACK]
    if not thin:
        piece = _holding(p, p, SLACK)
        planes = ConvexHull(p).equations
        heights = piece.vertices @ planes[:, :3].T + planes[:, 3]
        if heights.max() <= _MOST_GROWTH:
            return piece
        # With a layer on either side the edges of a wedge are blunt.
        thin = [axes[0]]
    layers = p
    for axis in thin:
        layers = np.vstack([layers - SLACK * axis, layers + SLACK * axis])
    return _holding(layers, p, 0.25 * SLACK)


def _holding(points: np.ndarray, p: np.ndarray, slack: float) -> ConvexPiece:
    """The hull of some points with few corners, stretched to hold others."""
    return stretched(convex_piece(points, slack, _MOST_CORNERS), p, _SPARE)


class Pieces:
    """Convex pieces as `standing_out` asks for them."""

    def __init__(self, pieces: list[ConvexPiece]):
        """Finds the planes of some pieces, at least one."""
        hulls = [ConvexHull(piece.vertices) for piece in pieces]
        counts = [len(hull.equations) for hull in hulls]
        self._first = np.cumsum([0, *counts[:-1]])
        planes = np.vstack([hull.equations for hull in hulls])
        self._normals, self._offsets = planes[:, :3].T.copy(), planes[:, 3]

    def outside_each(self, p: np.ndarray) -> np.ndarray:
        """Computes the greatest height of points above each piece's planes.

        Args:
            p: Points, shape (n, 3) [m].

        Returns:
            Shape (n, k) [m], negative inside; less than the distance where an
            edge or a corner is nearest.
        """
        heights = p @ self._normals + self._offsets
        return np.maximum.reduceat(heights, self._first, axis=1)
