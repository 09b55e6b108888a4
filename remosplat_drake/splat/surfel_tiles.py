"""`make_tiles`: converts a splat to small triangle meshes for Meshcat."""

import dataclasses as dc
from functools import lru_cache

import numpy as np

from remosplat_drake.base.colors import linear_rgb
from remosplat_drake.splat.bvh import build_hierarchy
from remosplat_drake.splat.gaussian_splat import GaussianSplat

MAX_SURFELS = 150_000
"""A Meshcat page shows at most this many discs, of about 250 bytes each."""

TILE_SIZE = 1000
"""Number of discs in a tile. Meshcat takes about 0.1 ms to receive a tile."""

SIDES = 6
"""Number of corners of the polygon that represents a disc in a tile."""

# Factor that brightens colours: a splat's colours already include lighting, and
# the page's lights would dim them again.
_EXPOSURE = 1.5


@dc.dataclass(frozen=True, eq=False)
class SurfelTile:
    """A triangle mesh of neighbouring discs, with read-only arrays.

    Attributes:
        vertices: Positions p_GV of the vertices, as columns, shape (3, 6 n),
            float32 [m].
        faces: Three vertex indices of each triangle, as columns, shape (3, 4
            n), int32.
        colors: Linear RGB of the vertices, brightened for the page's lights,
            shape (3, 6 n), float32.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colors: np.ndarray

    def __deepcopy__(self, memo) -> "SurfelTile":
        return self


def make_tiles(
    splat: GaussianSplat,
    order: np.ndarray | None = None,
    size: int = TILE_SIZE,
    *,
    n_sigma: float = 1.6,
    min_opacity: float = 0.1,
) -> tuple[SurfelTile, ...]:
    """Makes triangle meshes of a splat, each of some neighbouring discs.

    Args:
        splat: The scene in its frame G. If it has more than `MAX_SURFELS`
            splats, those with the largest area times opacity are used.
        order: Indices of the splats in an order in which neighbours are
            consecutive, like the leaf order of a hierarchy. If it is None, a
            hierarchy is built.
        size: Number of discs in a tile; the last tile may have fewer.
        n_sigma: Radius of the discs in standard deviations.
        min_opacity: Fainter splats are omitted. The default is the distance
            oracle's threshold, so that the page shows the obstacles of the
            robot.
    """
    if order is None:
        # A map of a building has too many discs to sort, so the largest discs
        # are selected first.
        splat = largest(splat, MAX_SURFELS, min_opacity)
        p_GK = splat.p_GK.astype(float)
        order = build_hierarchy(p_GK, p_GK, p_GK[:, 2]).order
    order = order[splat.opacities[order] >= min_opacity]
    shown = largest(splat.select(order), MAX_SURFELS)
    return tuple(
        _tile(shown.select(np.arange(k, min(k + size, len(shown)))), n_sigma)
        for k in range(0, len(shown), size)
    )


def surfel_mesh(
    splat: GaussianSplat, n_sigma: float, sides: int = SIDES
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Makes a mesh in which each splat is a regular polygon.

    Args:
        splat: N discs or ellipsoids.
        n_sigma: Circumradius of a polygon in standard deviations.
        sides: Number of corners of a polygon.

    Returns:
        Vertices p_GV (N * sides, 3) [m], faces (N * (sides - 2), 3), and linear
        RGB colours of the vertices (N * sides, 3), brightened for the page's
        lights. A polygon is in the plane of the splat's two largest axes.
    """
    rows = np.arange(len(splat))
    order = np.argsort(-splat.scales, axis=1, kind="stable")[:, :2]
    # These are the semi-axes of the polygons in G, shape (n, 2, 3).
    axes_G = n_sigma * np.stack(
        [splat.scales[rows, k, None] * splat.R_GK[rows, :, k] for k in order.T],
        axis=1,
    )
    angle = 2 * np.pi * np.arange(sides) / sides
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    p_GV = splat.p_GK[:, None] + np.einsum("sa,nax->nsx", corners, axes_G)
    colors = np.repeat(_EXPOSURE * linear_rgb(splat.colors), sides, axis=0)
    return p_GV.reshape(-1, 3), polygon_faces(len(splat), sides), colors


@lru_cache(maxsize=8)
def polygon_faces(count: int, sides: int) -> np.ndarray:
    """Triangulates polygons with consecutive corners as triangle fans.

    Args:
        count: Number of polygons.
        sides: Number of corners of each polygon.

    Returns:
        Vertex indices of the triangles, shape (count * (sides - 2), 3), int32,
        read-only. For equal arguments it is the same array, so that tiles of
        equal size share it.
    """
    fan = np.arange(1, sides - 1)
    polygon = np.stack([np.zeros_like(fan), fan, fan + 1], axis=1)
    faces = sides * np.arange(count)[:, None, None] + polygon
    faces = faces.reshape(-1, 3).astype(np.int32)
    faces.flags.writeable = False
    return faces


def largest(
    splat: GaussianSplat, count: int, min_opacity: float = 0.0
) -> GaussianSplat:
    """Returns the `count` splats with the largest area times opacity.

    Of splats with equal area times opacity, the first ones are returned. The
    splats keep their order.

    Args:
        splat: The splats.
        count: At most this many splats are returned.
        min_opacity: Fainter splats are omitted.
    """
    is_shown = splat.opacities >= min_opacity
    if np.count_nonzero(is_shown) > count:
        two = np.sort(splat.scales, axis=1)[:, -2:]
        cover = two[:, 0] * two[:, 1] * splat.opacities
        cover[~is_shown] = -1.0
        least = np.partition(cover, -count)[-count]
        is_shown = cover > least
        ties = np.flatnonzero(cover == least)
        is_shown[ties[: count - np.count_nonzero(is_shown)]] = True
    return splat if is_shown.all() else splat.select(is_shown)


def _tile(splat: GaussianSplat, n_sigma: float) -> SurfelTile:
    vertices, faces, colors = surfel_mesh(splat, n_sigma)
    vertices = vertices.astype(np.float32)
    colors = colors.astype(np.float32)
    for array in (vertices, colors):
        array.flags.writeable = False
    return SurfelTile(vertices.T, faces.T, colors.T)
