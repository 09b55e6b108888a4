"""`LinkSpheres`: spheres on one link, and how well they fit it."""

import dataclasses as dc

import numpy as np
from scipy.spatial.distance import cdist

from remosplat_drake.robot.fitting.solid_grid import SolidGrid


@dc.dataclass(frozen=True, eq=False)
class LinkSpheres:
    """The spheres fitted to one link.

    Attributes:
        p_LS: Centres in the link frame, shape (k, 3) [m].
        radius: Shape (k,) [m].
    """

    p_LS: np.ndarray
    radius: np.ndarray

    def outside(self, p: np.ndarray) -> np.ndarray:
        """Distance of points to the union of the spheres, negative inside.

        Args:
            p: Points in the link frame, shape (n, 3) [m].
        """
        if len(p) == 0:
            return np.zeros(0)
        return self.outside_each(p).min(axis=1)

    def outside_each(self, p: np.ndarray) -> np.ndarray:
        """Distance of points to each sphere, negative inside, (n, 3) to (n, k).

        Args:
            p: Points in the link frame [m].
        """
        return cdist(p, self.p_LS) - self.radius

    def grown_over(self, p: np.ndarray, margin: float) -> "LinkSpheres":
        """These spheres with radii that also enclose further points.

        Args:
            p: Points in the link frame, shape (n, 3) [m].
            margin: How deep inside points must lie that were outside [m].
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
    """How far a link's spheres stand out of it [m]."""

    mean: float
    max: float


def measure_bulge(
    spheres: LinkSpheres, solid: SolidGrid, directions: int = 2000
) -> Bulge:
    """How far the spheres' visible surface stands out of the solid.

    Args:
        spheres: Of one link.
        solid: The link's body.
        directions: Points on each sphere.
    """
    p_S = _sphere_directions(directions)
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


def _sphere_directions(n: int) -> np.ndarray:
    """Unit vectors on a Fibonacci spiral, shape (n, 3)."""
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.arange(n) * np.pi * (3 - np.sqrt(5))
    rho = np.sqrt(1 - z**2)
    return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), z])
