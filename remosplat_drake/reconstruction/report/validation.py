"""Cross-validation: what a map is worth at surfaces that it was made without.

Blocks of views that follow each other are left out, a map is made of the rest,
and the surfaces that those views measured judge it. A field that changes by at
most s when the query moves by s is nowhere too large, because of a surface
point, by more than what it says at that point. So a distance at a measured
point is an over-estimate. Less the discs' uncertainty, it is what no distance
allows for.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.uncertainty.depth_noise import (
    estimate_noise,
)
from remosplat_drake.reconstruction.uncertainty.measured_voxels import (
    measured_voxels,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

BLOCKS = 4
"""Number of blocks of views that are left out together."""

PART = 4
"""One of so many views is left out."""

LEAST_VIEWS = 24
"""Captures of fewer views cannot spare any."""

_LOOKS = 2
"""A point judges a map if so many of the map's views could have seen it."""

_HIDDEN = 0.02
"""A view could have seen a point that is behind what it measured by no more
than this [m]."""

_AROUND, _WITNESSES = 0.02, 3
"""An error counts as large as three measured points within 2 cm have it: one of
them may be a pixel that flew."""


@dc.dataclass(frozen=True, eq=False)
class Validation:
    """Errors of a map at n points of surfaces that it was made without.

    Attributes:
        p_W: The points, shape (n, 3) [m].
        over: Over-estimates of distances there, shape (n,) [m].
        excess: What is left of them where the discs' uncertainty is
            subtracted, shape (n,) [m]; negative where that is too much.
    """

    p_W: np.ndarray
    over: np.ndarray
    excess: np.ndarray

    def __len__(self) -> int:
        return len(self.p_W)

    @property
    def largest_over(self) -> float:
        """Largest over-estimate that several points bear out [m]."""
        return borne_out(self.p_W, self.over)

    @property
    def largest_excess(self) -> float:
        """Largest excess that several points bear out [m]; 0 for none."""
        return max(borne_out(self.p_W, self.excess), 0.0)

    @property
    def covered(self) -> float:
        """Fraction of the points at which no distance is too large."""
        return float((self.excess <= 0).mean()) if len(self) else 0.0


def left_out(views: int) -> np.ndarray:
    """Chooses the views that judge: blocks of views that follow each other.

    Neighbours in time share what their poses err by, and see the same from the
    same side. A view among its neighbours would judge too kindly.

    Args:
        views: Number of views of the capture.

    Returns:
        A mask of the views, shape (n,); none of a capture of few views.
    """
    mask = np.zeros(views, bool)
    if views < LEAST_VIEWS:
        return mask
    length = max(1, round(views / PART / BLOCKS))
    for block in range(BLOCKS):
        first = round((block + 0.5) * views / BLOCKS - length / 2)
        mask[first : first + length] = True
    return mask


def validate(
    splat_W: GaussianSplat,
    capture: Capture,
    judges: np.ndarray,
    workspace: Workspace,
) -> Validation:
    """Judges a map by views that it was made without.

    Args:
        splat_W: The map, with its discs' uncertainty, in W.
        capture: All views.
        judges: Which of them the map was made without, shape (n,), bool.
        workspace: Space in which errors matter.
    """
    rest = capture.select(~judges)
    noise = estimate_noise(rest, splat_W)
    measured = measured_voxels(capture.select(judges), noise)
    inside = (measured.p_W >= workspace.lower) & (
        measured.p_W <= workspace.upper
    )
    measured = measured.select(inside.all(axis=1) & (measured.views > 1))
    looks = times_looked_through(rest, measured.p_W, -_HIDDEN)
    p_W = measured.p_W[looks >= _LOOKS]
    raw = SphereToEllipsoidField(splat_W.with_uncertainty(None))
    careful = SphereToEllipsoidField(splat_W)
    return Validation(p_W, _at(raw, p_W), _at(careful, p_W))


def borne_out(p_W: np.ndarray, error: np.ndarray) -> float:
    """Returns the largest error that several neighbours have [m].

    Args:
        p_W: Points, shape (n, 3) [m].
        error: Their errors, shape (n,) [m].

    Returns:
        The largest number that `_WITNESSES` points near each other reach; -inf
        without such points.
    """
    if len(p_W) < _WITNESSES:
        return -np.inf
    tree, best = KDTree(p_W), -np.inf
    for index in np.argsort(-error, kind="stable"):
        if error[index] <= best:
            break
        near = tree.query_ball_point(p_W[index], _AROUND)
        if len(near) >= _WITNESSES:
            best = max(best, float(np.sort(error[near])[-_WITNESSES]))
    return best


def _at(field: DistanceField, p_W: np.ndarray) -> np.ndarray:
    """Distances at points (n, 3), shape (n,) [m]."""
    return field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))
