"""`DistanceQuality`: errors of a splat's distances against a reference."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True)
class DistanceQuality:
    """Errors of measured distances at points or spheres near a scene.

    Attributes:
        count: Number of points or spheres.
        median: Median of the absolute error [m].
        percentile_99: 99th percentile of the absolute error [m].
        over: Largest over-estimate of a distance, which hides an obstacle [m].
        under: Largest under-estimate of a distance, which invents an obstacle
            [m].
    """

    count: int
    median: float
    percentile_99: float
    over: float
    under: float


def distance_quality(
    field: DistanceField,
    truth: DistanceField,
    lower: np.ndarray,
    upper: np.ndarray,
    count: int = 20_000,
    nearest: float = 0.03,
    farthest: float = 0.5,
    seed: int = 0,
) -> DistanceQuality:
    """Compares two distance fields at random points of a box of W.

    Args:
        field: The distance field of the reconstruction.
        truth: The distance field of the ground truth, signed.
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        count: Number of points to draw.
        nearest: Least true distance of the points that are compared [m].
        farthest: Largest true distance of the points that are compared [m].
        seed: Seed of the random points.
    """
    points = np.random.default_rng(seed).uniform(lower, upper, (count, 3))
    spheres = Spheres.at(points)
    expected = truth.clearances(spheres).per_sphere(count)
    keep = (expected > nearest) & (expected < farthest)
    measured = field.clearances(spheres.select(keep)).per_sphere(keep.sum())
    return summarize(measured - expected[keep])


def summarize(error: np.ndarray) -> DistanceQuality:
    """Summarises errors (measured minus true distances), shape (n,) [m]."""
    return DistanceQuality(
        count=len(error),
        median=float(np.median(np.abs(error))),
        percentile_99=float(np.percentile(np.abs(error), 99)),
        over=float(error.max(initial=0.0)),
        under=float(-error.min(initial=0.0)),
    )
