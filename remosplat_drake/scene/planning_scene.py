"""Reads MoveIt's planning scenes from YAML, as published by MotionBenchMaker.

`world.collision_objects` lists objects. Each has an `id`, an optional `pose`,
`primitives`, and their `primitive_poses` in the object's frame. A primitive is
a `box` of three side lengths, or a `cylinder` of height and radius.
Orientations are quaternions x, y, z, w, which are normalised here.
"""

from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.foreign_yaml import ForeignValue
from remosplat_drake.base.reading import reads_file
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

SHAPES = {"box": 3, "cylinder": 2}
"""The supported shapes, with their numbers of dimensions."""

OTHER_SHAPES = ("meshes", "planes")
"""Fields of a collision object for unsupported shapes, which must be empty."""


@reads_file
def read_planning_scene(path: Path) -> dict[str, PrimitiveScene]:
    """Reads the objects of a planning scene, in the scene's frame.

    Args:
        path: The YAML file.

    Returns:
        The boxes and cylinders of each object, by the object's name.

    Raises:
        FileError: The file is missing or not YAML.
        FieldError: A field is missing or invalid, or a shape is unknown.
    """
    world = ForeignValue.read(path).get("world")
    objects: dict[str, PrimitiveScene] = {}
    for entry in world.get("collision_objects").items():
        name = entry.get("id").text()
        if name in objects:
            entry.get("id").fail(f"{name!r} appears twice")
        objects[name] = _object(entry, name)
    return objects


def _object(entry: ForeignValue, name: str) -> PrimitiveScene:
    for other in OTHER_SHAPES:
        shapes = entry.find(other)
        if shapes is not None and shapes.items():
            shapes.fail(f"unknown shape; valid: {', '.join(sorted(SHAPES))}")
    outer = entry.find("pose")
    X_SO = RigidTransform() if outer is None else _pose(outer)
    shapes = entry.get("primitives").items()
    poses = entry.get("primitive_poses").items()
    if len(poses) != len(shapes):
        entry.get("primitive_poses").fail(
            f"expected one for each of {len(shapes)} primitives,"
            f" got {len(poses)}"
        )
    primitives = [
        _primitive(shape, X_SO @ _pose(pose))
        for shape, pose in zip(shapes, poses, strict=True)
    ]
    return PrimitiveScene(
        boxes=tuple(p for p in primitives if isinstance(p, Box)),
        cylinders=tuple(p for p in primitives if isinstance(p, Cylinder)),
        name=name,
    )


def _primitive(shape: ForeignValue, X_SP: RigidTransform) -> Box | Cylinder:
    kind = shape.get("type")
    if kind.text() not in SHAPES:
        kind.fail(unknown_name("shape", kind.text(), SHAPES))
    dimensions = shape.get("dimensions")
    sizes = dimensions.numbers(SHAPES[kind.text()])
    try:
        if kind.text() == "box":
            return Box(X_SP, sizes / 2)
        height, radius = sizes
        return Cylinder(X_SP, float(radius), float(height) / 2)
    except RemoSplatError:
        dimensions.fail(f"must be positive, got {sizes.tolist()}")


def _pose(value: ForeignValue) -> RigidTransform:
    position = value.get("position").numbers(3)
    orientation = value.get("orientation")
    x, y, z, w = orientation.numbers(4)
    if np.linalg.norm([x, y, z, w]) < 0.5:
        orientation.fail("is not a rotation: the quaternion x, y, z, w is zero")
    unit = np.array([w, x, y, z]) / np.linalg.norm([x, y, z, w])
    return RigidTransform(RotationMatrix(Quaternion(unit)), position)
