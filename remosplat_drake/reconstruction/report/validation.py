"""Cross-validation: errors of a map at surfaces of held-out views.

Blocks of consecutive views are held out. A map is made from the other views,
and compared with the surfaces in the held-out views. At a measured surface
point, the true distance is zero, so the distance by the map is its
over-estimate. The distance by the map is 1-Lipschitz. So at any other position,
the map over-estimates the distance to this surface point by at most the same
length. The excess is the over-estimate after subtraction of the discs'
uncertainty.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.devices import CPU
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.reconstruction.pipeline import Report, reconstruct
from remosplat_drake.reconstruction.report.quality_report import (
    DEPTH_VIEWS,
    ELLIPSOIDS,
)
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
)
from remosplat_drake.reconstruction.surfels.refinement import RefinementConfig
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
"""Number of blocks of consecutive views that are held out."""

PART = 4
"""One view in this number of views is held out."""

LEAST_VIEWS = 24
"""Cross-validation needs a capture of at least this many views."""

UNFORESEEN = 2.8
"""Factor by which the verdict multiplies measured over-estimates, to allow for
surfaces that no held-out view shows. It was chosen on 27 captures of the study
`true_maps`, split `develop`."""

_LOOKS = 2
"""A point counts if at least this many of the map's views could have seen it.
"""

_HIDDEN = 0.02
"""A view could have seen a point if the point is at most this far behind the
surface that the view measured [m].
"""

NEAREST = 0.03
"""Distance from a surface at which depth views are evaluated [m]: the least
distance that the centre of a robot sphere can have.
"""

_ASIDE = 0.7
"""Ratio of a depth view's sideways offset from a surface point to its offset
towards the cameras.
"""

_WORST, _SPREAD = 400, 1000
"""Depth views are evaluated at this many points with the largest errors of
ellipsoids (first number), and at this many evenly chosen points (second
number).
"""

_SWEEPS, _LEAST_DISCS = 4, 1000
"""A map for evaluation is made with this many sweeps of the refinement (first
number) and at least this many discs (second number)."""

_AROUND, _WITNESSES = 0.02, 3
"""Points confirm each other's errors if they are within this radius [m] (first
number). At least this many points must share an error (second number). A single
point may be a flying pixel.
"""


_NOTHING = 1.0  # Distance by an oracle without a surface in range [m].


@dc.dataclass(frozen=True, eq=False)
class Validation:
    """Errors of a map at n points of held-out surfaces.

    Attributes:
        oracle: Name of the oracle that measured the distances.
        p_W: The points in W, shape (n, 3) [m].
        over: Over-estimates of distances at the points, shape (n,) [m].
        excess: Over-estimates minus the discs' uncertainty, shape (n,) [m];
            negative if the uncertainty is larger.
    """

    oracle: str
    p_W: np.ndarray
    over: np.ndarray
    excess: np.ndarray

    def __len__(self) -> int:
        return len(self.p_W)

    @property
    def is_conclusive(self) -> bool:
        """Whether there are enough points for a result."""
        return bool(np.isfinite(self.largest_over))

    @property
    def largest_over(self) -> float:
        """Largest over-estimate that several points confirm [m]."""
        return confirmed_maximum(self.p_W, self.over)

    @property
    def verdict(self) -> float:
        """Bound on over-estimates of the map [m].

        It is `UNFORESEEN` times the largest over-estimate, since the held-out
        views show only a part of all surfaces. The discs' uncertainty is not
        subtracted, because otherwise a worse capture with less certain discs
        would get a better verdict.
        """
        return UNFORESEEN * max(self.largest_over, 0.0)

    @property
    def covered(self) -> float:
        """Fraction of points whose over-estimate is within the uncertainty."""
        return float((self.excess <= 0).mean()) if len(self) else 0.0


@dc.dataclass(frozen=True, eq=False)
class Validations:
    """Errors of a map at held-out surfaces, measured by each oracle.

    Attributes:
        ellipsoids: Errors of distances to ellipsoids; None: not measured.
        depth_views: Errors of distances by depth views; None: not measured.
    """

    ellipsoids: Validation | None = None
    depth_views: Validation | None = None

    @property
    def of_oracles(self) -> list[Validation]:
        """The errors of the oracles that were measured."""
        both = self.ellipsoids, self.depth_views
        return [each for each in both if each is not None]


def left_out(views: int) -> np.ndarray:
    """Selects held-out views: blocks of consecutive views.

    Consecutive views have similar pose errors and viewing directions. If single
    views were held out, they would agree too well with their neighbours, and
    the errors would be underestimated.

    Args:
        views: Number of views of the capture.

    Returns:
        A mask of the views, shape (n,); all False if the capture has too few
        views.
    """
    mask = np.zeros(views, bool)
    if views < LEAST_VIEWS:
        return mask
    length = max(1, round(views / PART / BLOCKS))
    for block in range(BLOCKS):
        first = round((block + 0.5) * views / BLOCKS - length / 2)
        mask[first : first + length] = True
    return mask


def cross_validate(
    capture: Capture,
    workspace: Workspace,
    errors: PoseErrors | None = None,
    initialisation: InitialisationConfig | None = None,
    report: Report = lambda stage, done, total: None,
) -> Validations:
    """Makes a map without some views, and measures its errors at these views.

    This map is made on the CPU, with half as many discs and fewer sweeps than
    the real map, so its errors are not smaller than the real map's.

    Args:
        capture: All views, refined.
        workspace: Box in which errors are measured.
        errors: Draws of the errors of the cameras, in the capture's frame.
        initialisation: Settings of the initial surfels; None: the defaults.
        report: Called with the progress, see `Report`.

    Returns:
        The errors of each oracle; both None if the capture has too few views.
    """
    judges = left_out(len(capture))
    if not judges.any():
        return Validations()
    initialisation = initialisation or InitialisationConfig()
    splat_W = reconstruct(
        capture,
        CPU,
        initialisation=dc.replace(
            initialisation, count=max(initialisation.count // 2, _LEAST_DISCS)
        ),
        refinement=RefinementConfig(sweeps=_SWEEPS),
        bounded=True,
        errors=errors,
        held_out=judges,
        report=report,
    ).splat
    return validate(splat_W, capture, judges, workspace)


def validate(
    splat_W: GaussianSplat,
    capture: Capture,
    judges: np.ndarray,
    workspace: Workspace,
) -> Validations:
    """Measures errors of a map at held-out views.

    Args:
        splat_W: The map, with its discs' uncertainty, in W.
        capture: All views.
        judges: Mask of the views that were not used for the map, shape (n,),
            bool.
        workspace: Box in which errors are measured.

    Returns:
        The errors of each oracle.
    """
    rest = capture.select(~judges)
    noise = estimate_noise(rest, splat_W)
    measured = measured_voxels(capture.select(judges), noise)
    inside = (measured.p_W >= workspace.lower) & (
        measured.p_W <= workspace.upper
    )
    measured = measured.select(inside.all(axis=1) & (measured.views > 1))
    looks = times_looked_through(rest, measured.p_W, -_HIDDEN)
    measured = measured.select(looks >= _LOOKS)
    bare_W = splat_W.with_uncertainty(None)
    over, excess = (
        _at(SphereToEllipsoidField(splat), measured.p_W)
        for splat in (bare_W, splat_W)
    )
    chosen = _chosen(over)
    seen_W, back_W = measured.p_W[chosen], -measured.ray_W[chosen]
    views = [
        _before(
            DepthRasterizationField(splat, nearest_only=True), seen_W, back_W
        )
        for splat in (bare_W, splat_W)
    ]
    return Validations(
        Validation(ELLIPSOIDS, measured.p_W, over, excess),
        Validation(DEPTH_VIEWS, seen_W, *views),
    )


def _chosen(over: np.ndarray) -> np.ndarray:
    """Indices of points for depth views: some, and those with the worst errors.

    Depth views take much longer than ellipsoids, and have errors at the same
    points.
    """
    worst = np.argsort(-over, kind="stable")[:_WORST]
    spread = np.arange(0, len(over), max(1, len(over) // _SPREAD))
    return np.unique(np.concatenate([worst, spread]))


def _before(
    field: DistanceField, p_W: np.ndarray, back_W: np.ndarray
) -> np.ndarray:
    """Over-estimates of distances in front of surface points, (n,) [m].

    A depth view cannot be evaluated on a surface. So it is placed in front of
    the surface, in the direction of the cameras and sideways of it, and the
    largest error counts.

    Args:
        field: The map.
        p_W: The points, shape (n, 3) [m].
        back_W: Directions to the cameras, shape (n, 3).
    """
    if not len(p_W):
        return np.zeros(0)
    x_W = np.cross(back_W, [0.3, 0.5, 0.8])
    x_W /= np.linalg.norm(x_W, axis=1, keepdims=True)
    y_W = np.cross(back_W, x_W)
    errors = []
    for a, b in ((0, 0), (_ASIDE, 0), (-_ASIDE, 0), (0, _ASIDE), (0, -_ASIDE)):
        away_W = back_W + a * x_W + b * y_W
        away_W /= np.linalg.norm(away_W, axis=1, keepdims=True)
        errors.append(_at(field, p_W + NEAREST * away_W) - NEAREST)
    return np.max(errors, axis=0)


def confirmed_maximum(p_W: np.ndarray, error: np.ndarray) -> float:
    """Returns the largest error that several neighbouring points share [m].

    Args:
        p_W: Points, shape (n, 3) [m].
        error: Errors at the points, shape (n,) [m].

    Returns:
        The largest value that the errors of `_WITNESSES` neighbouring points
        reach; -inf if there are no such points.
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
    distance = field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))
    return np.minimum(distance, _NOTHING)
