"""The map, the movers, or both contain a box."""

from collections.abc import Iterable

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover
from remosplat_drake.signals.distance_field import DistanceField


def who_knows(
    place: np.ndarray,
    half_extents: np.ndarray,
    field: DistanceField,
    movers: Iterable[Mover],
) -> set[str]:
    """Whether "map" shows the box's top, and "movers" enclose its middle."""
    known = set()
    top = Spheres.at(np.add(place, [0, 0, half_extents[2]]))
    if field.clearances(top, 0.5).minimum() < 0.03:
        known.add("map")
    for mover in movers:
        p_M = mover.X_WM.inverse().multiply(place)
        out = np.maximum(np.abs(p_M) - mover.half_extents, 0)
        if np.linalg.norm(out) <= mover.radius:
            known.add("movers")
    return known
