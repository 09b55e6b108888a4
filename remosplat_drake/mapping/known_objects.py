"""Excludes known objects from a map that is built from frames."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.oracle.own_points import own_points
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.coverage import FREE, UNSEEN, Coverage

_MARGIN = 0.015
"""Measured points within this distance of an object's surface show the object
[m]. The distance exceeds the pose error of an object that the robot has placed.
"""

Placed = Sequence[Sequence[PlacedObject]]
"""The known objects with their poses, for each of n frames."""


def at_poses(
    things: Sequence[SceneObject], placed: Sequence[PlacedObject]
) -> list[tuple[SceneObject, bool]]:
    """Returns the objects at the given poses, and whether each is supported.

    Args:
        things: The objects at any poses.
        placed: The poses; poses of unknown names are ignored.
    """
    by_name = {each.name: each for each in things}
    return [
        (by_name[each.name].at(RigidTransform(each.X_WO)), each.stands)
        for each in placed
        if each.name in by_name
    ]


def find_own_pixels(
    capture: Capture, things: Sequence[SceneObject], placed: Placed
) -> np.ndarray:
    """Finds the pixels that show known objects.

    Args:
        capture: n frames.
        things: The objects.
        placed: The objects at each frame.

    Returns:
        Shape (n, h, w), bool.
    """
    own = np.zeros(capture.depth.shape, bool)
    for i, present in enumerate(placed):
        if not present:
            continue
        known = capture.depth[i] > 0
        p_W = capture.points_W(i)[known]
        near = np.zeros(len(p_W), bool)
        for thing, stands in at_poses(things, present):
            near |= own_points(p_W, thing, _MARGIN, stands=stands)
        own[i][known] = near
    return own


def with_known_insides(
    coverage: Coverage, things: Sequence[SceneObject], placed: Placed
) -> Coverage:
    """Marks the unseen space inside known objects as free.

    The map must not contain the objects' space, since the controller adds the
    objects at their present poses.

    Args:
        coverage: The seen space without the known objects.
        things: The objects.
        placed: The objects at each frame.
    """
    if not any(map(len, placed)):
        return coverage
    state = coverage.state.copy()
    unseen = np.argwhere(state == UNSEEN)
    middle = coverage.lower + coverage.voxel * (unseen + 0.5)
    half = 0.5 * np.sqrt(3.0) * coverage.voxel
    places = {
        (each.name, each.X_WO.tobytes()): each
        for present in placed
        for each in present
    }
    for thing, _ in at_poses(things, list(places.values())):
        off = middle - thing.X_WO.translation()
        near = np.flatnonzero(
            np.einsum("ij,ij->i", off, off) <= (thing.reach + half) ** 2
        )
        distance = (
            ObjectField([thing]).clearances(Spheres.at(middle[near])).distance
        )
        state[tuple(unseen[near[distance <= half]].T)] = FREE
    return dc.replace(coverage, state=state)
