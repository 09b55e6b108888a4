"""How well a reconstruction measures distances, against known geometry."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True)
class DistanceQuality:
    """Errors of measured distances, over points or spheres near a scene.

    Attributes:
        count: Number of them.
        median: Of the absolute error [m].
        percentile_99: Of the absolute error [m].
        over: Largest over-estimate, which hides an obstacle [m].
        under: Largest under-estimate, which invents one [m].
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
    """Compares two fields at random points of a box of W.

    Args:
        field: The reconstruction's.
        truth: The ground truth's, signed.
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner, shape (3,) [m].
        count: Number of points to draw.
        nearest: Points truly nearer than this are left out [m].
        farthest: And those truly farther [m].
        seed: Of the random points.
    """
    points = np.random.default_rng(seed).uniform(lower, upper, (count, 3))
    spheres = Spheres.at(points)
    expected = truth.clearances(spheres).per_sphere(count)
    keep = (expected > nearest) & (expected < farthest)
    measured = field.clearances(spheres.select(keep)).per_sphere(keep.sum())
    return summarize(measured - expected[keep])


def summarize(error: np.ndarray) -> DistanceQuality:
    """The quality that errors, measured minus true distance, (n,) [m], mean."""
    return DistanceQuality(
        count=len(error),
        median=float(np.median(np.abs(error))),
        percentile_99=float(np.percentile(np.abs(error), 99)),
        over=float(error.max(initial=0.0)),
        under=float(-error.min(initial=0.0)),
    )
