"""Removes objects from a scene: from its splat, and from its true geometry."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.oracle.own_points import own_points
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

OWN_MARGIN = 0.01
"""By default, a splat belongs to an object if its distance from the object's
surface is at most this [m]."""


def own_splats(
    splat_W: GaussianSplat, thing: SceneObject, margin: float
) -> np.ndarray:
    """Finds the splats that represent an object.

    A splat belongs to the object if its centre is near the object's surface.
    Splats at the object's foot are excluded, since they may belong to its
    support.

    Args:
        splat_W: The scene's splat, in W.
        thing: The object.
        margin: Splats farther than this from the object's surface do not
            represent the object [m].

    Returns:
        Whether each splat represents the object, shape (N,).
    """
    return own_points(np.array(splat_W.p_GK, float), thing, margin)


def with_solids(
    truth: PrimitiveScene | None, objects: Sequence[SceneObject]
) -> PrimitiveScene | None:
    """Adds objects to a true scene that does not contain their names.

    Args:
        truth: The true scene; None if it is unknown.
        objects: The objects. Convex hulls are not added.
    """
    if truth is None:
        return None
    names = {solid.name for solid in truth.primitives}
    new = [x.solid for x in objects if x.name not in names]
    return dc.replace(
        truth,
        boxes=(*truth.boxes, *(x for x in new if isinstance(x, Box))),
        cylinders=(
            *truth.cylinders,
            *(x for x in new if isinstance(x, Cylinder)),
        ),
    )


def without_objects(
    truth: PrimitiveScene, objects: Sequence[SceneObject]
) -> PrimitiveScene:
    """Returns a true scene without the solids of objects.

    Args:
        truth: The true scene.
        objects: The objects. Solids with their names are removed.
    """
    names = {each.name for each in objects}
    return dc.replace(
        truth,
        boxes=tuple(x for x in truth.boxes if x.name not in names),
        cylinders=tuple(x for x in truth.cylinders if x.name not in names),
    )
