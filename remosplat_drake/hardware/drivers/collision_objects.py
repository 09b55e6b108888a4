"""`CollisionObjects`: converts MoveIt's collision objects for a scenario."""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.planning_scene import OTHER_SHAPES, SHAPES

_ADD, _REMOVE, _APPEND, _MOVE = range(4)
"""Values of CollisionObject.operation."""

_NAMES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone", 5: "prism"}
"""Names of the values of SolidPrimitive.type."""

_DIGITS = 6


@dc.dataclass(frozen=True, eq=False)
class _Thing:
    """An object: its pose, and its shapes with their poses in its frame.

    Attributes:
        X_WO: Pose of the object's frame O in W.
        shapes: The object's shapes, as pairs of a shape's pose X_OS and its
            fields in a scenario.
    """

    X_WO: RigidTransform
    shapes: tuple[tuple[RigidTransform, dict[str, Any]], ...] = ()


class CollisionObjects:
    """The objects of a planning scene, after all messages so far."""

    def __init__(self, frame: str):
        """Starts without an object.

        Args:
            frame: Name of the frame that is the scenario's world W.
        """
        self._frame = frame.strip("/")
        self._things: dict[str, _Thing] = {}

    def put_scene(self, message) -> list[str]:
        """Applies a moveit_msgs/PlanningScene, either complete or a difference.

        Args:
            message: The message.

        Returns:
            For each rejected object a text with its name and the reason.
        """
        if not message.is_diff:
            self._things.clear()
        problems = map(self.put, message.world.collision_objects)
        return [problem for problem in problems if problem]

    def put(self, message) -> str:
        """Applies a moveit_msgs/CollisionObject.

        If the message is invalid, the object is removed.

        Args:
            message: The message.

        Returns:
            The object's name and the reason for its rejection; empty if it was
            not rejected.
        """
        name, operation = message.id, message.operation
        if operation == _REMOVE and not name:
            self._things.clear()
            return ""
        known = self._things.pop(name, None)
        if operation == _REMOVE:
            return ""
        try:
            self._things[name] = self._changed(known, message)
        except (RemoSplatError, RuntimeError) as error:
            return f"object {name!r} is left out: {error}"
        return ""

    def entries(self) -> list[dict[str, Any]]:
        """Returns the objects as entries for a scenario's `objects`.

        An object of several shapes becomes several entries, with numbers in
        their names.
        """
        entries = []
        for name, thing in self._things.items():
            for i, (X_OS, shape) in enumerate(thing.shapes, start=1):
                X_WS = thing.X_WO @ X_OS
                rows = X_WS.rotation().matrix()
                pose = {
                    "translation": _rounded(X_WS.translation()),
                    "rotation": [_rounded(row) for row in rows],
                }
                called = f"{name} {i}" if len(thing.shapes) > 1 else name
                entries.append(
                    {"name": called, "X_WO": pose, "in_splat": False} | shape
                )
        return entries

    def _changed(self, known: _Thing | None, message) -> _Thing:
        """Returns an object after a message about it.

        Raises:
            RemoSplatError: The message is unusable.
        """
        frame = message.header.frame_id.strip("/")
        if frame != self._frame:
            raise RemoSplatError(f"frame_id is {frame!r}, not {self._frame!r}")
        X_WO, kept = _pose(message.pose), ()
        if message.operation in (_APPEND, _MOVE) and known is not None:
            kept = known.shapes
        if message.operation == _APPEND and known is not None:
            X_WO = known.X_WO
        return _Thing(X_WO, kept + _shapes(message, X_WO))


def _shapes(
    message, X_WO: RigidTransform
) -> tuple[tuple[RigidTransform, dict[str, Any]], ...]:
    """Reads the shapes of a message, in the frame O.

    Raises:
        RemoSplatError: A shape is neither a box nor a cylinder.
    """
    for other in OTHER_SHAPES:
        if getattr(message, other):
            raise RemoSplatError(f"it has {other}; give boxes or cylinders")
    if len(message.primitives) != len(message.primitive_poses):
        raise RemoSplatError("the numbers of primitives and poses differ")
    X_OM = X_WO.inverse() @ _pose(message.pose)
    return tuple(
        (X_OM @ _pose(pose), _shape(solid))
        for solid, pose in zip(
            message.primitives, message.primitive_poses, strict=True
        )
    )


def _shape(solid) -> dict[str, Any]:
    """Converts a shape_msgs/SolidPrimitive to a scenario's fields."""
    kind = _NAMES.get(solid.type, f"of type {solid.type}")
    sizes = _rounded(solid.dimensions)
    if kind not in SHAPES:
        raise RemoSplatError(f"it is a {kind}; give boxes or cylinders")
    if len(sizes) != SHAPES[kind] or not min(sizes) > 0:
        raise RemoSplatError(
            f"its {kind} has the dimensions {sizes}, not {SHAPES[kind]}"
            " positive numbers"
        )
    if kind == "box":
        return {"box": sizes}
    height, radius = sizes
    return {"cylinder": {"radius": radius, "height": height}}


def _pose(pose) -> RigidTransform:
    """Converts a geometry_msgs/Pose; a zero quaternion means no rotation.

    Raises:
        RemoSplatError: A number is not finite.
    """
    p, r = pose.position, pose.orientation
    quaternion = np.array([r.w, r.x, r.y, r.z])
    if not np.isfinite([p.x, p.y, p.z, *quaternion]).all():
        raise RemoSplatError("its pose has a number that is not finite")
    length = float(np.linalg.norm(quaternion))
    unit = quaternion / length if length > 0 else np.array([1.0, 0, 0, 0])
    return RigidTransform(Quaternion(unit), [p.x, p.y, p.z])


def _rounded(values) -> list[float]:
    return [round(float(value), _DIGITS) + 0.0 for value in values]
