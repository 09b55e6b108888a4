"""Covering a mesh with convex pieces that stand out of it by little.

CoACD (Wei et al., SIGGRAPH 2022) cuts a mesh until no point of a part's convex
hull is farther from the part than a threshold, which is the error that
distances have. It may drop, close or thicken what is no proper solid, so that
its parts need not hold the whole mesh. What they miss is added to the nearest;
the pieces that come out enclose every triangle.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    convex_piece,
    stretched,
)
from remosplat_drake.robot.fitting.enclosure import in_four, standing_out

SLACK = 5e-4
"""How far corners that a piece does without may be outside it [m]. Pieces are
stretched by what this takes, so that they enclose all in the end."""

_ROUNDING = 2e-6
"""By how much pieces enclose what they hold, as files are in micrometres."""

_SMALLEST = 4e-3
"""Edge below which a triangle that is in no part goes to one as a whole [m]: it
crosses a cut, mostly."""

_MOST_TRIANGLES = 2000
"""Triangles of a mesh that CoACD sees; larger meshes are simplified for it."""

_SEARCH = {
    "preprocess_resolution": 30,
    "mcts_iterations": 30,
    "mcts_nodes": 8,
    "mcts_max_depth": 1,
    "resolution": 500,
}
"""How hard CoACD looks for the best cuts, and how finely it redraws what is no
solid. With its own defaults a link takes minutes, with these seconds."""


def decompose(surface: np.ndarray, threshold: float) -> list[ConvexPiece]:
    """Covers a surface with convex pieces.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].
        threshold: How far a piece may stand out of what it covers [m], but for
            `SLACK`; infinite for the hull of it all.

    Returns:
        The pieces, which enclose the surface together.

    Raises:
        RemoSplatError: The surface is flat.
        MissingExtraError: CoACD is not installed (extra `robots`).
    """
    parts = [surface.reshape(-1, 3)]
    if np.isfinite(threshold):
        parts = _with_all_of(_cut(surface, threshold), surface)
    kept = [convex_piece(part, SLACK) for part in parts]
    slack = 0.0 if len(parts) == 1 else SLACK
    for _ in range(8):
        pieces = [
            stretched(piece, part, slack + _ROUNDING)
            for piece, part in zip(kept, parts, strict=True)
        ]
        if len(pieces) == 1 or standing_out(surface, Pieces(pieces)) <= 0.0:
            return pieces
        slack += 0.5 * SLACK
    raise RemoSplatError("no convex pieces that enclose it were found")


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


def _cut(surface: np.ndarray, threshold: float) -> list[np.ndarray]:
    """The corners of the parts that CoACD cuts a surface into."""
    coacd = import_optional("coacd", "cutting meshes", "robots")
    coacd.set_log_level("off")
    vertices, triangles = _welded(surface)
    if len(triangles) > _MOST_TRIANGLES:
        simplify = import_optional(
            "fast_simplification", "cutting meshes", "robots"
        ).simplify
        vertices, triangles = simplify(
            vertices.astype(np.float32),
            triangles,
            target_count=_MOST_TRIANGLES,
        )
    parts = coacd.run_coacd(
        coacd.Mesh(vertices.astype(float), triangles),
        threshold=threshold,
        real_metric=True,
        **_SEARCH,
    )
    solid = [np.asarray(p, float) for p, _ in parts if _is_solid(p)]
    return solid or [surface.reshape(-1, 3)]


def _welded(surface: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles whose equal corners are one."""
    vertices, triangles = np.unique(
        surface.reshape(-1, 3).round(7), axis=0, return_inverse=True
    )
    triangles = triangles.reshape(-1, 3)
    a, b, c = triangles.T
    return vertices, triangles[(a != b) & (b != c) & (c != a)]


def _is_solid(p: np.ndarray) -> bool:
    try:
        return ConvexHull(p).volume > 0.0
    except (QhullError, ValueError):
        return False


def _with_all_of(
    parts: list[np.ndarray], surface: np.ndarray
) -> list[np.ndarray]:
    """Adds what of a surface is in no part to the parts that are nearest."""
    hulls = Pieces([convex_piece(part, SLACK) for part in parts])
    added: list[list[np.ndarray]] = [[part] for part in parts]
    todo = surface
    while len(todo):
        outside = hulls.outside_each(todo.reshape(-1, 3))
        bound = outside.reshape(len(todo), 3, -1).max(axis=1)
        missed = bound.min(axis=1) > SLACK
        todo, bound = todo[missed], bound[missed]
        edges = np.linalg.norm(todo - np.roll(todo, 1, axis=1), axis=2)
        small = edges.max(axis=1, initial=0.0) < _SMALLEST
        for i in np.unique(nearest := bound.argmin(axis=1)):
            chosen = todo[small & (nearest == i)]
            added[i].append(chosen.reshape(-1, 3))
        todo = in_four(todo[~small])
    return [np.vstack(points) for points in added]
