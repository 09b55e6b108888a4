"""`Solid`: a shape with a pose and an appearance, part of a rendered scene."""

import colorsys
import dataclasses as dc
from collections.abc import Iterable

import numpy as np
import pydrake.geometry as drake_geometry
from pydrake.geometry import (
    CalcObb,
    HalfSpace,
    PerceptionProperties,
    Rgba,
    Shape,
)
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene


@dc.dataclass(frozen=True, eq=False)
class Solid:
    """A fixed shape with frame G, and its appearance.

    Attributes:
        X_WG: Pose of the shape's frame G in W.
        shape: A shape of Drake (`pydrake.geometry.Shape`).
        look: Perception properties for Drake's renderers. A mesh's own colours
            replace them.
    """

    X_WG: RigidTransform
    shape: Shape
    look: PerceptionProperties

    def moved(self, X: RigidTransform) -> "Solid":
        """Returns the solid, moved by X in W."""
        return dc.replace(self, X_WG=X @ self.X_WG)


def painted(rgba: Iterable[float]) -> PerceptionProperties:
    """Makes perception properties with one colour.

    Args:
        rgba: Red, green, blue and alpha as display (sRGB) values in [0, 1].
    """
    look = PerceptionProperties()
    look.AddProperty("phong", "diffuse", Rgba(*rgba))
    return look


def primitive_solids(scene: PrimitiveScene) -> tuple[Solid, ...]:
    """Makes solids of primitives: wooden boxes, and coloured other shapes."""
    return tuple(
        Solid(primitive.X_WP, drake_shape(primitive), _look(primitive, i))
        for i, primitive in enumerate(scene.primitives)
    )


def drake_shape(primitive: Box | Cylinder) -> Shape:
    """Converts a primitive to Drake's shape of the same frame."""
    if isinstance(primitive, Box):
        return drake_geometry.Box(*(2 * primitive.half_extents))
    return drake_geometry.Cylinder(primitive.radius, 2 * primitive.half_height)


def extent(solids: Iterable[Solid]) -> tuple[np.ndarray, np.ndarray]:
    """Computes a box in W that contains all solids.

    The box may be larger than necessary, since it contains a box around each
    rotated solid. Half-spaces are infinite, and are ignored.

    Returns:
        Lower and upper corner, both of shape (3,) [m].

    Raises:
        RemoSplatError: All solids are half-spaces.
    """
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    corners = []
    for solid in solids:
        if isinstance(solid.shape, HalfSpace):
            continue
        box = CalcObb(solid.shape)
        X_WO = (solid.X_WG @ box.pose()).GetAsMatrix4()
        p_OV = signs * box.half_width()
        corners.append(p_OV @ X_WO[:3, :3].T + X_WO[:3, 3])
    if not corners:
        raise RemoSplatError("the scene has no solid of finite size")
    points = np.concatenate(corners)
    return points.min(axis=0), points.max(axis=0)


def _look(primitive: Box | Cylinder, index: int) -> PerceptionProperties:
    """The hues of successive solids differ by the golden ratio."""
    turn = (0.618034 * index) % 1.0
    hsv = (
        (0.07 + 0.04 * turn, 0.2 + 0.3 * turn, 0.9)
        if isinstance(primitive, Box)
        else (turn, 0.55, 0.85)
    )
    return painted([*colorsys.hsv_to_rgb(*hsv), 1.0])
