"""Covering a mesh with convex pieces that stand out of it by little.

CoACD (Wei et al., SIGGRAPH 2022) cuts a mesh until no point of a part's convex
hull is farther from the part than a threshold, which is the error that
distances have. It closes, drops or thickens what is no proper solid, so that
its parts are not quite the mesh's. They tell where to cut: every triangle is
cut until each bit lies in a part, or is small, and the pieces are the hulls of
what belongs to each part.
"""

import numpy as np

# CoACD brings parts of a C++ library that Drake needs its own of: where CoACD
# is loaded first, Drake reads no file any more.
import pydrake.common  # noqa: F401
from scipy.spatial import ConvexHull, QhullError

from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    convex_piece,
    stretched,
)
from remosplat_drake.robot.fitting.enclosure import in_four

SLACK = 5e-4
"""How far corners that a piece does without may be outside it [m]. Pieces are
stretched by what this takes, so that they enclose all in the end."""

_MOST_CORNERS = 200
"""Corners of a piece from which on it does without more: ticks look at all."""

_SPARE = 6e-5
"""How deep in the pieces all lies [m]: files are in micrometres, and
`standing_out` sees no less."""

_SMALLEST = 4e-3
"""Edge below which a triangle that is in no part goes to the nearest [m]: it
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
        parts = _shared_out(surface, _cut(surface, threshold))
    return [_piece(part) for part in parts]


def _piece(p: np.ndarray) -> ConvexPiece:
    """The hull of points with few corners, which holds them all the same."""
    slack = SLACK
    while len((piece := convex_piece(p, slack)).vertices) > _MOST_CORNERS:
        slack *= 1.4
    return stretched(piece, p, _SPARE)


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


def _shared_out(
    surface: np.ndarray, parts: list[np.ndarray]
) -> list[np.ndarray]:
    """Gives each triangle of a surface to the part that it is deepest in.

    Those that are in none are cut in four until they are, or are small. What a
    part has of the surface stands for it: it may have been redrawn thicker.
    """
    hulls = Pieces([convex_piece(part, SLACK) for part in parts])
    shares: list[list[np.ndarray]] = [[] for _ in parts]
    todo = surface
    while len(todo):
        outside = hulls.outside_each(todo.reshape(-1, 3))
        bound = outside.reshape(len(todo), 3, -1).max(axis=1)
        nearest = bound.argmin(axis=1)
        edges = np.linalg.norm(todo - np.roll(todo, 1, axis=1), axis=2)
        settled = bound.min(axis=1) <= SLACK
        settled |= edges.max(axis=1) < _SMALLEST
        for i, own in enumerate(shares):
            own.append(todo[settled & (nearest == i)].reshape(-1, 3))
        todo = in_four(todo[~settled])
    points = [np.vstack(own) for own in shares]
    return [
        p if _is_solid(p) else np.vstack([p, part])
        for p, part in zip(points, parts, strict=True)
        if len(p)
    ]
