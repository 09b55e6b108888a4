"""`PrimitiveScene`: a scene of boxes and cylinders, known exactly."""

import dataclasses as dc
import hashlib
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError


@dc.dataclass(frozen=True, eq=False)
class Box:
    """A solid box.

    Attributes:
        X_WP: Pose of the box's frame P, at its centre, in W.
        half_extents: Half side lengths along P's axes, shape (3,) [m].
        name: Display name, "shelf" for example; may be empty.

    Raises:
        RemoSplatError: A half side length is not positive.
    """

    X_WP: RigidTransform
    half_extents: np.ndarray
    name: str = ""

    def __post_init__(self):
        half_extents = np.array(self.half_extents, float)
        _check_positive("half_extents", half_extents, (3,))
        object.__setattr__(self, "half_extents", half_extents)

    @cached_property
    def top(self) -> float:
        """Height of the highest point in W [m]."""
        R_WP = self.X_WP.rotation().matrix()
        reach = np.abs(R_WP[2]) @ self.half_extents
        return float(self.X_WP.translation()[2] + reach)


@dc.dataclass(frozen=True, eq=False)
class Cylinder:
    """A solid cylinder.

    Attributes:
        X_WP: Pose of the cylinder's frame P in W: its origin is the centre, its
            z axis the cylinder's axis.
        radius: Radius [m].
        half_height: Half the length along the axis [m].
        name: Display name, "can" for example; may be empty.
    """

    X_WP: RigidTransform
    radius: float
    half_height: float
    name: str = ""

    def __post_init__(self):
        for name in ("radius", "half_height"):
            _check_positive(name, np.array(getattr(self, name), float), ())

    @cached_property
    def top(self) -> float:
        """Height of the highest point in W [m]."""
        cosine = abs(self.X_WP.rotation().matrix()[2, 2])
        sine = np.sqrt(max(0.0, 1.0 - cosine**2))
        reach = cosine * self.half_height + sine * self.radius
        return float(self.X_WP.translation()[2] + reach)


@dc.dataclass(frozen=True, eq=False)
class PrimitiveScene:
    """A scene of solid boxes and cylinders, and a task in it.

    Scenes are immutable: a deep copy is the object itself.

    Attributes:
        boxes: The boxes, which may overlap each other and the cylinders.
        cylinders: The cylinders, which may overlap each other and the boxes.
        X_WE_target: Target pose of the end effector E, or None.
        X_WB_start: Pose (x, y, yaw) of the robot's base B to start from [m,
            rad], or None.
        name: Name of the scene, for tables, logs and file names.
    """

    boxes: tuple[Box, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    X_WE_target: RigidTransform | None = None
    X_WB_start: tuple[float, float, float] | None = None
    name: str = "scene"

    def __post_init__(self):
        object.__setattr__(self, "boxes", tuple(self.boxes))
        object.__setattr__(self, "cylinders", tuple(self.cylinders))

    def __len__(self) -> int:
        return len(self.boxes) + len(self.cylinders)

    def __deepcopy__(self, memo) -> "PrimitiveScene":
        return self

    @property
    def primitives(self) -> tuple[Box | Cylinder, ...]:
        """All primitives, boxes first; indices of primitives refer to them."""
        return (*self.boxes, *self.cylinders)

    def name_of(self, i: int) -> str:
        """Returns the name of a primitive, for use in a sentence.

        Args:
            i: Index of the primitive in `primitives`.
        """
        primitive = self.primitives[i]
        if primitive.name:
            return f"the {primitive.name}"
        if isinstance(primitive, Box):
            return f"box {i + 1}"
        return f"cylinder {i + 1 - len(self.boxes)}"

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 digest of the geometry (not of task or name), in hex."""
        digest = hashlib.sha256()
        for box in self.boxes:
            digest.update(b"box")
            digest.update(box.X_WP.GetAsMatrix34().tobytes())
            digest.update(box.half_extents.tobytes())
        for cylinder in self.cylinders:
            digest.update(b"cylinder")
            digest.update(cylinder.X_WP.GetAsMatrix34().tobytes())
            size = np.array([cylinder.radius, cylinder.half_height], float)
            digest.update(size.tobytes())
        return digest.hexdigest()[:16]

    def with_floor(
        self,
        center: tuple[float, float] = (0.6, 0.0),
        half_extent: float = 2.0,
        thickness: float = 0.04,
    ) -> "PrimitiveScene":
        """Adds a square floor slab whose top is the plane z = 0.

        Args:
            center: Centre (x, y) of the slab in W [m].
            half_extent: Half the side length of the slab [m].
            thickness: Thickness of the slab below z = 0 [m].

        Returns:
            A new scene; the slab is its last box.
        """
        floor = Box(
            RigidTransform([*center, -thickness / 2]),
            np.array([half_extent, half_extent, thickness / 2]),
            "floor",
        )
        return dc.replace(self, boxes=(*self.boxes, floor))


def _check_positive(name: str, values: np.ndarray, shape: tuple[int, ...]):
    if values.shape != shape or not (
        np.isfinite(values).all() and (values > 0).all()
    ):
        raise RemoSplatError(
            f"{name} must be positive numbers of shape {shape}, got {values}"
        )
