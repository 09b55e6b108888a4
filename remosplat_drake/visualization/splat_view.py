"""`SplatView`: a Gaussian splat as surfels or as points."""

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.perception import BaseField, Fields, PointCloud

from remosplat_drake.colors import linear_rgb
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.page import ROOT, MeshcatPage
from remosplat_drake.visualization.toggle import Toggle

SURFELS = f"{ROOT}/splat/surfels"
POINTS = f"{ROOT}/splat/points"
MAX_SURFELS = 150_000
"""More discs than this make the page heavy (about 250 bytes each)."""

_POINT_SIZE = 0.015
# A splat's colours hold their light already; the page's dims them again.
_EXPOSURE = 1.5
_SIDES = 6


class SplatView:
    """Draws a splat once; a button steps through surfels, points and off.

    Args:
        page: Where to draw.
        splat: The scene in its frame G.
        X_WG: Pose of the scene in the world.
        n_sigma: Radius of the discs in standard deviations.
        min_opacity: Fainter splats are not drawn; the distance oracle's
            default, so that the page shows what the robot avoids.
    """

    def __init__(
        self,
        page: MeshcatPage,
        splat: GaussianSplat,
        X_WG: RigidTransform | None = None,
        *,
        n_sigma: float = 1.6,
        min_opacity: float = 0.1,
    ):
        self._meshcat = page.meshcat
        self._n_sigma = n_sigma
        self._min_opacity = min_opacity
        self._meshcat.SetTransform(f"{ROOT}/splat", X_WG or RigidTransform())
        self.draw(splat)
        page.add_toggle(
            Toggle(
                page.meshcat,
                label="Splat: surfels / points / off",
                keycode="Digit1",
                states=[[SURFELS], [POINTS], []],
            )
        )

    def draw(self, splat: GaussianSplat):
        """Shows another splat in the place of the present one."""
        splat = splat.select(splat.opacities >= self._min_opacity)
        _draw_points(self._meshcat, splat)
        vertices, faces, colors = surfel_mesh(
            largest(splat, MAX_SURFELS), self._n_sigma
        )
        self._meshcat.SetTriangleColorMesh(
            SURFELS, vertices.T, faces.T, _EXPOSURE * colors.T
        )


def surfel_mesh(
    splat: GaussianSplat, n_sigma: float, sides: int = _SIDES
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Regular polygons, stretched over the two largest axes of each splat.

    Args:
        splat: N discs or ellipsoids.
        n_sigma: Circumradius in standard deviations.
        sides: Number of corners of a polygon.

    Returns:
        Vertices p_GV (N * sides, 3) [m], faces (N * (sides - 2), 3) and
        linear RGB colours of the vertices (N * sides, 3).
    """
    n = len(splat)
    rows = np.arange(n)
    order = np.argsort(-splat.scales, axis=1, kind="stable")[:, :2]
    # Semi-axes of the polygons in G, shape (n, 2, 3).
    axes_G = n_sigma * np.stack(
        [splat.scales[rows, k, None] * splat.R_GK[rows, :, k] for k in order.T],
        axis=1,
    )
    angle = 2 * np.pi * np.arange(sides) / sides
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    p_GV = splat.p_GK[:, None] + np.einsum("sa,nax->nsx", corners, axes_G)

    fan = np.arange(1, sides - 1)
    polygon = np.stack([np.zeros_like(fan), fan, fan + 1], axis=1)
    faces = sides * rows[:, None, None] + polygon
    colors = np.repeat(linear_rgb(splat.colors), sides, axis=0)
    return p_GV.reshape(-1, 3), faces.reshape(-1, 3).astype(np.int32), colors


def largest(splat: GaussianSplat, count: int) -> GaussianSplat:
    """At most `count` splats: those that cover most, by area and opacity."""
    if len(splat) <= count:
        return splat
    two = np.sort(splat.scales, axis=1)[:, -2:]
    cover = two[:, 0] * two[:, 1] * splat.opacities
    return splat.select(np.sort(np.argsort(-cover, kind="stable")[:count]))


def _draw_points(meshcat: Meshcat, splat: GaussianSplat):
    cloud = PointCloud(len(splat), Fields(BaseField.kXYZs | BaseField.kRGBs))
    cloud.mutable_xyzs()[:] = splat.p_GK.T
    rgb = np.clip(splat.colors.T, 0.0, 1.0)
    cloud.mutable_rgbs()[:] = np.round(255 * rgb).astype(np.uint8)
    meshcat.SetObject(POINTS, cloud, point_size=_POINT_SIZE)
