"""Finds the names of objects at points of the scene."""

import numpy as np

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.thing import MAP, THE_FLOOR, Thing

_OF_A_SOLID = 0.03
"""A map's surface is at most this far from the solid that it represents [m]."""


def name_thing(
    field: DistanceField,
    p_W: np.ndarray,
    floor_height: float = -np.inf,
    truth: SignedDistanceField | None = None,
) -> Thing:
    """Returns the kind and name of the object at a point.

    The surfaces of a map have no names. If the point is on the floor, or near a
    solid of the true scene, the result has the name of the floor or of this
    solid.

    Args:
        field: The map.
        p_W: A point on a surface, in W, shape (3,) [m].
        floor_height: Height in W below which a surface belongs to the floor
            [m].
        truth: The true scene, whose solids have names; None if unknown.
    """
    thing = field.thing_at(p_W)
    if thing.kind == MAP and p_W[2] <= floor_height:
        return THE_FLOOR
    if thing.kind == MAP and truth is not None:
        off = abs(truth.clearances(Spheres.at(p_W)).minimum())
        if off <= _OF_A_SOLID:
            thing = Thing(MAP, truth.thing_at(p_W).name)
    return THE_FLOOR if thing.name == THE_FLOOR.name else thing
