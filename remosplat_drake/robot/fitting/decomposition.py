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

from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.fitting.convex_pieces import (
    convex_piece,
    hull_volume,
)
from remosplat_drake.robot.fitting.enclosing_piece import SLACK, Pieces
from remosplat_drake.robot.fitting.enclosure import in_four
from remosplat_drake.robot.fitting.kernels.owners import owners
from remosplat_drake.robot.fitting.simplified import simplified, welded

_SMALL, _SMALLEST = 1e-2, 1e-3
"""Edges below which a triangle that is in no part goes to the part that is
nearest to all of its corners, and to the nearest at all [m]: it crosses a cut,
mostly."""

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


def decompose(surface: np.ndarray, threshold: float) -> list[np.ndarray]:
    """Shares a surface out to parts that are nearly convex.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].
        threshold: How far a part's hull may stand out of the part [m].

    Returns:
        The triangles of each part, shape (s, 3, 3) each [m]; those that cross a
        cut are cut in four, again and again.

    Raises:
        MissingExtraError: CoACD is not installed (extra `robots`).
    """
    return _shared_out(surface, _cut(surface, threshold))


def _cut(surface: np.ndarray, threshold: float) -> list[np.ndarray]:
    """The corners of the parts that CoACD cuts a surface into."""
    coacd = import_optional("coacd", "cutting meshes", "robots")
    coacd.set_log_level("off")
    vertices, triangles = welded(simplified(surface, _MOST_TRIANGLES))
    parts = coacd.run_coacd(
        coacd.Mesh(vertices, triangles),
        threshold=threshold,
        real_metric=True,
        **_SEARCH,
    )
    corners = [np.asarray(p, float) for p, _ in parts]
    solid = [p for p in corners if hull_volume(p) > 0.0]
    return solid or [surface.reshape(-1, 3)]


def _shared_out(
    surface: np.ndarray, parts: list[np.ndarray]
) -> list[np.ndarray]:
    """Gives each triangle of a surface to the part that it is deepest in.

    Those that are in none are cut in four until they are, or until they are
    small and all nearest to one part. What a part has of the surface stands for
    it: it may have been redrawn thicker.
    """
    hulls = Pieces([convex_piece(part, SLACK) for part in parts])
    shares: list[list[np.ndarray]] = [[] for _ in parts]
    todo = surface
    while len(todo):
        owner = owners(
            todo, hulls.planes, hulls.first, SLACK, _SMALL, _SMALLEST
        )
        for i, own in enumerate(shares):
            own.append(todo[owner == i])
        todo = in_four(todo[owner < 0])
    joined = [np.concatenate(own) for own in shares]
    return [part for part in joined if len(part)]
