"""Adds the scene's boxes and cylinders to a plant, as static geometry."""

import numpy as np
from pydrake.geometry import Box as BoxShape
from pydrake.geometry import Cylinder as CylinderShape
from pydrake.geometry import Shape
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.station.contact_materials import scene_material

BOX_COLOUR = np.array([0.76, 0.60, 0.42, 1.0])  # Light wood.
CYLINDER_COLOUR = np.array([0.85, 0.42, 0.30, 1.0])  # Terracotta.
FLOOR_COLOUR = np.array([0.82, 0.83, 0.85, 1.0])

FLOOR_SIDE = 20.0
"""Side of the square floor [m]."""

FLOOR_THICKNESS = 0.2
"""Thickness of the floor, whose top is at z = 0 [m]."""

_AT_FLOOR = 1e-3
"""Largest distance of the top of a floor from z = 0 [m]."""

_BELOW = 0.1
"""If a solid reaches farther below z = 0 than this, z = 0 is not the floor [m].
"""


def add_scene_geometry(
    plant: MultibodyPlant, scene: PrimitiveScene | None, *, solid: bool
) -> None:
    """Adds the scene and a floor at z = 0 to a plant's world body.

    No floor is added if the scene contains a floor, which is a box with its top
    at z = 0, or if a solid, such as a leg of a table, reaches far below z = 0.

    Args:
        plant: A plant that is the source of a scene graph, before `Finalize`.
        scene: The solids in the scene; None for an empty scene.
        solid: Whether the robot collides with the scene. If not, the scene is
            only visible.
    """
    primitives = list(scene.primitives) if scene else []
    for i, primitive in enumerate(primitives):
        shape, colour, kind = _appearance(primitive)
        _register(plant, primitive.X_WP, shape, f"{kind}_{i}", colour, solid)
    if _needs_floor(primitives):
        slab = BoxShape(FLOOR_SIDE, FLOOR_SIDE, FLOOR_THICKNESS)
        X_WP = RigidTransform([0, 0, -FLOOR_THICKNESS / 2])
        _register(plant, X_WP, slab, "floor", FLOOR_COLOUR, solid)


def _needs_floor(primitives: list[Box | Cylinder]) -> bool:
    """Returns whether a scene has neither a floor nor solids below z = 0."""
    return not any(
        _bottom(primitive) < -_BELOW
        or (isinstance(primitive, Box) and abs(primitive.top) < _AT_FLOOR)
        for primitive in primitives
    )


def _bottom(primitive: Box | Cylinder) -> float:
    """Returns the height of a primitive's lowest point [m]."""
    return 2.0 * primitive.X_WP.translation()[2] - primitive.top


def _register(
    plant: MultibodyPlant,
    X_WP: RigidTransform,
    shape: Shape,
    name: str,
    colour: np.ndarray,
    solid: bool,
) -> None:
    world = plant.world_body()
    plant.RegisterVisualGeometry(world, X_WP, shape, name, colour)
    if solid:
        size = shape.radius() if isinstance(shape, CylinderShape) else 1.0
        plant.RegisterCollisionGeometry(
            world, X_WP, shape, name, scene_material(size)
        )


def _appearance(primitive: Box | Cylinder) -> tuple[Shape, np.ndarray, str]:
    if isinstance(primitive, Box):
        return BoxShape(*(2 * primitive.half_extents)), BOX_COLOUR, "box"
    shape = CylinderShape(primitive.radius, 2 * primitive.half_height)
    return shape, CYLINDER_COLOUR, "cylinder"
