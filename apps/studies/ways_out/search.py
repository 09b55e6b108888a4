"""A search for a way out that is independent of the controller.

It is a random climb: a step is accepted if no distance that is too small
decreases, and no other one becomes too small.
"""

import numpy as np

from apps.studies.ways_out.start import Place, Posture

_TRIES = 6
"""Number of climbs."""

_STEPS = 3000
"""Number of steps of each climb."""

_LONGEST, _SHORTEST = 0.1, 1e-4
"""Largest and smallest length of a step [rad, m]."""

_ROUNDING = 1e-6
"""A step may decrease a distance that is too small by at most this [m], because
of rounding."""


def finds_a_way(
    place: Place, start: Posture, random: np.random.Generator
) -> bool:
    """Searches for a way out of a start.

    Args:
        place: The robot, its map and its control law.
        start: The start.
        random: Source of randomness for the steps.
    """
    return any(_climbs(place, start, random) for _ in range(_TRIES))


def _climbs(place: Place, start: Posture, random: np.random.Generator) -> bool:
    robot, q = place.world.robot, start.q

    def margins_at(q: np.ndarray) -> np.ndarray:
        margins = place.margins(q, start.movers)
        return np.concatenate([margins, place.joint_margins(q)])

    lower = np.minimum(robot.position_lower, q)
    upper = np.maximum(robot.position_upper, q)
    kept = np.minimum(margins_at(q), 0.0)
    length, direction = 0.01, random.normal(size=robot.n_u)
    for _ in range(_STEPS):
        u = direction / np.linalg.norm(direction) * length
        after = robot.advance(q, u, 1.0)
        margins = margins_at(after)
        inside = ((lower <= after) & (after <= upper)).all()
        if inside and (margins >= kept - _ROUNDING).all():
            if (margins >= 0.0).all():
                return True
            # A successful direction is kept, with a small random change.
            q, kept = after, np.maximum(kept, np.minimum(margins, 0.0))
            length = min(1.5 * length, _LONGEST)
            direction = u / length + 0.3 * random.normal(size=robot.n_u)
        else:
            length = max(0.7 * length, _SHORTEST)
            direction = random.normal(size=robot.n_u)
            direction *= random.random(robot.n_u) < random.uniform(0.2, 1.0)
            direction[0] += 1e-9
    return False
