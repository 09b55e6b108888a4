"""The promises of `verify.py` about a command, checked very densely.

Slow, and without any bound in between: what tests hold the fast check
against.
"""

import numpy as np
from verified_commands import Around, at, tube_of

from remosplat_drake.controller.verification.kernels.between_samples import (
    tolerated,
)


def least_margins(
    around: Around, u: np.ndarray, samples: int = 200
) -> tuple[float, float]:
    """Measures how much more distance a command's path leaves than it must.

    Args:
        around: Robot, map and present state.
        u: The command, shape (n_u,) [rad/s, m/s].
        samples: Number of samples in each tick of the path.

    Returns:
        The smallest margin, that is distance above the level to be kept, of all
        spheres and pairs of shapes at the ends of ticks; and at all samples the
        smallest above what is tolerated between these [m].
    """
    path = around.path(u)
    kept = _kept(around, tube_of(around.robot, path))
    times = np.concatenate([[0.0], path.times])
    ends, between = [], []
    for k in range(len(path.times)):
        for time in np.linspace(times[k], times[k + 1], samples + 1)[1:]:
            margins = _margins(around, at(path, [time])[0], kept)
            between.append(margins[1])
        ends.append(margins[0])
    return min(ends), min(between)


Kept = list[tuple[np.ndarray, np.ndarray]]
"""Levels of the spheres, and of the pairs if there are any, with what is
tolerated below each between the ends of ticks [m]."""


def _kept(around: Around, tube: np.ndarray) -> Kept:
    """Works out the distances to be kept all along a path."""
    level = np.minimum(around.stopping + tube, around.clearance)
    kept = [(level, around.stopping)]
    own = around.self_clearance
    if own is not None:
        level = np.minimum(own.stopping, own.distances(around.start))
        kept.append((level, own.stopping))
    return [
        (level, np.array([tolerated(one, stopping) for one in level]))
        for level, stopping in kept
    ]


def _margins(around: Around, q: np.ndarray, kept: Kept) -> tuple[float, float]:
    """Measures the smallest margins at a configuration [m]."""
    spheres = around.robot.spheres_at(q)
    found = [around.field.clearances(spheres).per_sphere(len(spheres))]
    if around.self_clearance is not None:
        found.append(around.self_clearance.distances(q))
    margin, beyond = np.inf, np.inf
    for distance, (level, slack) in zip(found, kept, strict=True):
        margin = min(margin, (distance - level).min(initial=np.inf))
        beyond = min(beyond, (distance - level + slack).min(initial=np.inf))
    return float(margin), float(beyond)
