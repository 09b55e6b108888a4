"""`SplatView`: a Gaussian splat as surfels or as points."""

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.perception import BaseField, Fields, PointCloud

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import MAX_SURFELS, largest, surfel_mesh
from remosplat_drake.visualization.page import ROOT, MeshcatPage
from remosplat_drake.visualization.toggle import Toggle

SURFELS = f"{ROOT}/splat/surfels"
POINTS = f"{ROOT}/splat/points"
_POINT_SIZE = 0.015


class SplatView:
    """Draws a splat once; a button steps through surfels, points and off.

    Args:
        page: The page to draw on.
        splat: The splat in its frame G.
        X_WG: Pose of the splat in the world; None for the identity.
        n_sigma: Radius of the discs in standard deviations.
        min_opacity: Opacity below which Gaussians are not drawn; the distance
            oracle's default, so that the page shows what the robot avoids.
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
        """Draws another splat in the place of the present one."""
        splat = splat.select(splat.opacities >= self._min_opacity)
        _draw_points(self._meshcat, splat)
        vertices, faces, colors = surfel_mesh(
            largest(splat, MAX_SURFELS), self._n_sigma
        )
        self._meshcat.SetTriangleColorMesh(
            SURFELS, vertices.T, faces.T, colors.T
        )


def _draw_points(meshcat: Meshcat, splat: GaussianSplat):
    cloud = PointCloud(len(splat), Fields(BaseField.kXYZs | BaseField.kRGBs))
    cloud.mutable_xyzs()[:] = splat.p_GK.T
    rgb = np.clip(splat.colors.T, 0.0, 1.0)
    cloud.mutable_rgbs()[:] = np.round(255 * rgb).astype(np.uint8)
    meshcat.SetObject(POINTS, cloud, point_size=_POINT_SIZE)
