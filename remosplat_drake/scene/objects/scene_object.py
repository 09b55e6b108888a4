"""`SceneObject`: a named rigid object of a scene that a hand may take."""

import dataclasses as dc
from collections.abc import Collection, Sequence
from itertools import count

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.primitive_scene import Box, Cylinder

Solid = Box | Cylinder | ConvexHull
"""The shapes of objects."""


@dc.dataclass(frozen=True, eq=False)
class SceneObject:
    """A rigid object: a named solid with a pose and a mass.

    The object's frame O is the solid's frame P. The class is immutable: `at`
    returns a new object with another pose, and a deep copy is the object
    itself.

    Attributes:
        name: Name of the object, which no other object of the scene has.
        solid: Shape of the object, placed in W.
        mass: Mass of the object [kg]; None if it is unknown.

    Raises:
        RemoSplatError: The name is empty, or the mass is not positive.
    """

    name: str
    solid: Solid
    mass: float | None = None

    def __post_init__(self):
        if not self.name.strip():
            raise RemoSplatError("an object needs a name")
        if self.mass is not None and not 0.0 < self.mass < np.inf:
            raise RemoSplatError(
                f"object {self.name!r}: the mass must be positive,"
                f" got {self.mass}"
            )

    def __deepcopy__(self, memo) -> "SceneObject":
        return self

    @property
    def X_WO(self) -> RigidTransform:
        """Pose of the object's frame O in W."""
        return self.solid.X_WP

    @property
    def top(self) -> float:
        """Height of its highest point in W [m]."""
        return self.solid.top

    @property
    def reach(self) -> float:
        """Radius of a ball around O that contains the object [m]."""
        return float(np.linalg.norm(np.abs(self.corners).max(axis=0)))

    @property
    def corners(self) -> np.ndarray:
        """Corners of its bounding box in O, lower and upper, (2, 3) [m]."""
        solid = self.solid
        if isinstance(solid, ConvexHull):
            points = solid.vertices
            return np.array([points.min(axis=0), points.max(axis=0)])
        if isinstance(solid, Box):
            half = solid.half_extents
        else:
            half = np.array([solid.radius, solid.radius, solid.half_height])
        return np.array([-half, half])

    def at(self, X_WO: RigidTransform) -> "SceneObject":
        """Returns the same object with another pose.

        Args:
            X_WO: New pose of the object in W.
        """
        return dc.replace(self, solid=dc.replace(self.solid, X_WP=X_WO))


def check_names(objects: Sequence[SceneObject]) -> None:
    """Checks that no two objects have the same name.

    Raises:
        RemoSplatError: Two objects have the same name.
    """
    names = [each.name for each in objects]
    for i, name in enumerate(names):
        if name in names[:i]:
            raise RemoSplatError(f"two objects are named {name!r}")


def new_name(names: Collection[str]) -> str:
    """Returns the first of "object 1", "object 2", ... that is no name yet.

    Args:
        names: The names of all objects.
    """
    return next(name for i in count(1) if (name := f"object {i}") not in names)


def find_object(objects: Sequence[SceneObject], name: str) -> SceneObject:
    """Returns the object with a name.

    Raises:
        RemoSplatError: No object has this name.
    """
    for each in objects:
        if each.name == name:
            return each
    names = [each.name for each in objects]
    raise RemoSplatError(unknown_name("object", name, names))
