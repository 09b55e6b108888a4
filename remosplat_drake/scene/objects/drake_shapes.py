"""Converts objects to Drake's shapes and inertias."""

from pydrake.geometry import Box as DrakeBox
from pydrake.geometry import Convex, Shape
from pydrake.geometry import Cylinder as DrakeCylinder
from pydrake.multibody.tree import CalcSpatialInertia, SpatialInertia

from remosplat_drake.scene.objects.scene_object import SceneObject, Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder


def drake_shape(solid: Solid) -> Shape:
    """Returns Drake's shape of a solid, in the solid's frame.

    Args:
        solid: The solid.
    """
    if isinstance(solid, Box):
        return DrakeBox(*(2.0 * solid.half_extents))
    if isinstance(solid, Cylinder):
        return DrakeCylinder(solid.radius, 2.0 * solid.half_height)
    return Convex(solid.vertices.T, solid.name or "hull")


def object_inertia(thing: SceneObject) -> SpatialInertia:
    """Returns an object's spatial inertia about O, expressed in O.

    The density is assumed uniform.

    Args:
        thing: The object; if its mass is unknown, 1 kg is assumed.
    """
    unit = CalcSpatialInertia(drake_shape(thing.solid), 1.0)
    mass = 1.0 if thing.mass is None else thing.mass
    return SpatialInertia(mass, unit.get_com(), unit.get_unit_inertia())
