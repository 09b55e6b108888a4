"""`LinkSpheres`: spheres on one link, and their protrusion from the link."""

import dataclasses as dc

import numpy as np
import scipy

from remosplat_drake.base.directions import spread_directions
from remosplat_drake.robot.fitting.solid_grid import SolidGrid


@dc.dataclass(frozen=True, eq=False)
class LinkSpheres:
    """k spheres that were fitted to one link.

    Attributes:
        p_LS: Centres in the link frame, shape (k, 3) [m].
        radius: Radii, shape (k,) [m].
    """

    p_LS: np.ndarray
    radius: np.ndarray

    def outside(self, p: np.ndarray) -> np.ndarray:
        """Computes the signed distance of points to the union of the spheres.

        Args:
            p: Points in the link frame, shape (n, 3) [m].

        Returns:
            Shape (n,) [m], negative inside.
        """
        if len(p) == 0:
            return np.zeros(0)
        return self.outside_each(p).min(axis=1)

    def outside_each(self, p: np.ndarray) -> np.ndarray:
        """Computes the signed distance of points to each sphere.

        Args:
            p: Points in the link frame, shape (n, 3) [m].

        Returns:
            Shape (n, k) [m], negative inside.
        """
        return scipy.spatial.distance.cdist(p, self.p_LS) - self.radius

    def grown_over(self, p: np.ndarray, margin: float) -> "LinkSpheres":
        """Enlarges the radii so that the spheres also enclose further points.

        Args:
            p: Points in the link frame, shape (n, 3) [m].
            margin: Points that were outside are at least this deep inside an
                enlarged sphere [m].
        """
        missed = p[self.outside(p) > 0]
        radius = self.radius.copy()
        for point in missed:
            lack = np.linalg.norm(point - self.p_LS, axis=1) - radius
            nearest = lack.argmin()
            radius[nearest] += max(lack[nearest] + margin, 0.0)
        return LinkSpheres(self.p_LS, radius)


@dc.dataclass(frozen=True)
class Bulge:
    """Mean and largest protrusion of a link's spheres from the link [m]."""

    mean: float
    max: float


def measure_bulge(
    spheres: LinkSpheres, solid: SolidGrid, directions: int = 2000
) -> Bulge:
    """Measures the distance by which the spheres' union protrudes from a solid.

    Args:
        spheres: The spheres of one link.
        solid: The link's body.
        directions: Number of points on each sphere.
    """
    p_S = spread_directions(directions)
    out = [np.zeros(0)]
    for i, (centre, radius) in enumerate(
        zip(spheres.p_LS, spheres.radius, strict=True)
    ):
        p = centre + radius * p_S
        others = np.arange(len(spheres.radius)) != i
        rest = LinkSpheres(spheres.p_LS[others], spheres.radius[others])
        visible = p if not others.any() else p[rest.outside(p) > 0]
        out.append(-solid.depth_at(visible))
    beyond = np.maximum(np.concatenate(out), 0.0)
    if len(beyond) == 0:
        return Bulge(0.0, 0.0)
    return Bulge(float(beyond.mean()), float(beyond.max()))
