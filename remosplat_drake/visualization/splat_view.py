"""`SplatView`: draws a Gaussian splat as surfels or as points."""

from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import MAX_SURFELS, largest
from remosplat_drake.visualization.instanced_splat import InstancedSplat
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT
from remosplat_drake.visualization.toggle import Toggle

SURFELS = f"{ROOT}/splat/surfels"
POINTS = f"{ROOT}/splat/points"
N_SIGMA = 1.6
"""Radius of the discs in standard deviations."""

MIN_OPACITY = 0.1
"""Gaussians with a lower opacity are not drawn. The limit equals the default of
the distance oracle, so that the page shows the Gaussians that the robot
avoids."""

_POINT_RADIUS = 0.006  # [m]


class SplatView:
    """Draws a splat; a button selects surfels, points, or neither.

    If a splat is too large for a browser, the largest discs are drawn, and the
    page states their number.

    Args:
        page: The page to draw on.
        splat: The splat in its frame G.
        X_WG: Pose of the splat in the world; None for the identity.
    """

    def __init__(
        self,
        page: MeshcatPage,
        splat: GaussianSplat,
        X_WG: RigidTransform | None = None,
    ):
        meshcat = page.meshcat
        meshcat.SetTransform(f"{ROOT}/splat", X_WG or RigidTransform())
        shown = opaque(splat, MAX_SURFELS)
        if len(shown):
            instanced = InstancedSplat(shown, N_SIGMA)
            meshcat.SetObject(SURFELS, instanced.surfels())
            meshcat.SetObject(POINTS, instanced.points(_POINT_RADIUS))
        if len(shown) == MAX_SURFELS < len(splat):
            page.set_status(shown_of(len(shown), len(splat)), "splat")
        page.add_toggle(
            Toggle(
                "Splat",
                "1",
                (("discs", (SURFELS,)), ("points", (POINTS,)), ("off", ())),
            )
        )


def shown_of(shown: int, count: int) -> str:
    """Returns a text if a page does not show all Gaussians; else "".

    Args:
        shown: Number of splats that the page shows.
        count: Number of all splats.
    """
    return f"{shown:,} of {count:,} splats shown"


def draw_surfels(
    meshcat: Meshcat, path: str, splat: GaussianSplat, count: int
) -> None:
    """Draws a splat's largest discs; draws nothing if there are none.

    Args:
        meshcat: The Meshcat server.
        path: Path in the scene tree.
        splat: The splat in the path's frame.
        count: At most this many discs are drawn.
    """
    shown = opaque(splat, count)
    if len(shown):
        meshcat.SetObject(path, InstancedSplat(shown, N_SIGMA).surfels())


def opaque(splat: GaussianSplat, count: int) -> GaussianSplat:
    """Returns the largest Gaussians among those that are opaque enough."""
    return largest(splat, count, MIN_OPACITY)
