"""Objects in scene files (JSON), beside the solids of `scene/rmmi.py`.

    {"cubes": [], "cylinders": [],
     "objects": [
      {"name": "can", "position": [1.0, 0.2, 0.66], "mass": 0.35,
       "cylinder": {"radius": 0.033, "height": 0.12}}]}

`position` and `quaternion` (w, x, y, z; absent: upright) are the pose X_WO. An
object has one of `box` (`size`, its three side lengths), `cylinder` (`radius`,
`height`) and `hull` (`file`, a mesh whose convex hull is the shape, relative to
the scene file, and `scale`). `mass` may be absent.
"""

from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.base.json_fields import JsonFields
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_json import read_json_object
from remosplat_drake.scene.objects.convex_hull import ConvexHull, read_hull
from remosplat_drake.scene.objects.scene_object import SceneObject, Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder

SHAPES = {
    "box": ("size",),
    "cylinder": ("radius", "height"),
    "hull": ("file", "scale"),
}
"""The shapes of objects, and their fields."""

_POSE = ("position", "quaternion")


@reads_file
def read_objects(path: str | Path) -> tuple[SceneObject, ...]:
    """Reads the objects of a scene file; a file without `objects` has none.

    Args:
        path: The JSON file, or its `package://` URI.

    Raises:
        FileError: The file, or a mesh that it names, cannot be read.
        FieldError: A key is missing or unknown, a value is invalid, or two
            objects have the same name.
    """
    path = resources.expand(path)
    document = JsonFields(read_json_object(path), str(path))
    if not document.has("objects"):
        return ()
    objects: list[SceneObject] = []
    for entry in document.inners("objects"):
        read = _object(entry, path.parent)
        if any(read.name == other.name for other in objects):
            raise entry.error("name", f"two objects are named {read.name!r}")
        objects.append(read)
    return tuple(objects)


def object_entry(thing: SceneObject, hull_file: str = "") -> dict[str, object]:
    """Returns the entry of an object in a scene file.

    Args:
        thing: The object.
        hull_file: Name of the mesh file, which the caller writes; only for
            convex hulls.
    """
    X_WO, solid = thing.X_WO, thing.solid
    entry: dict[str, object] = {
        "name": thing.name,
        "position": X_WO.translation().tolist(),
        "quaternion": X_WO.rotation().ToQuaternion().wxyz().tolist(),
    }
    if isinstance(solid, Box):
        entry["box"] = {"size": (2.0 * solid.half_extents).tolist()}
    elif isinstance(solid, Cylinder):
        height = 2.0 * float(solid.half_height)
        entry["cylinder"] = {"radius": float(solid.radius), "height": height}
    else:
        entry["hull"] = {"file": hull_file}
    if thing.mass is not None:
        entry["mass"] = float(thing.mass)
    return entry


def _object(entry: JsonFields, folder: Path) -> SceneObject:
    _check_keys(entry, ("name", *_POSE, "mass", *SHAPES))
    given = [shape for shape in SHAPES if entry.has(shape)]
    if len(given) != 1:
        problem = f"give one of {', '.join(SHAPES)}, got {len(given)}"
        raise entry.error("shape", problem)
    name, X_WO = entry.text("name"), _pose(entry)
    mass = entry.number("mass") if entry.has("mass") else None
    shape = entry.inner(given[0])
    _check_keys(shape, SHAPES[given[0]])
    try:
        return SceneObject(name, _solid(given[0], shape, X_WO, folder), mass)
    except FieldError:
        raise
    except RemoSplatError as error:
        raise entry.error(given[0], str(error)) from error


def _solid(
    kind: str, shape: JsonFields, X_WO: RigidTransform, folder: Path
) -> Solid:
    if kind == "box":
        return Box(X_WO, np.array(shape.numbers("size", 3)) / 2.0)
    if kind == "cylinder":
        height = shape.number("height")
        return Cylinder(X_WO, shape.number("radius"), height / 2.0)
    scale = shape.number("scale", 1e-6, 1e6) if shape.has("scale") else 1.0
    file = resources.resolve(shape.text("file"), folder)
    return ConvexHull(X_WO, read_hull(file, scale))


def _check_keys(entry: JsonFields, valid: tuple[str, ...]) -> None:
    for name in entry.names():
        if name not in valid:
            raise entry.error(name, unknown_name("key", name, valid))


def _pose(entry: JsonFields) -> RigidTransform:
    R_WO = RotationMatrix()
    if entry.has("quaternion"):
        quaternion = np.array(entry.numbers("quaternion", 4), float)
        if not np.linalg.norm(quaternion) > 0.5:
            raise entry.error("quaternion", "is not a rotation")
        unit = quaternion / np.linalg.norm(quaternion)
        R_WO = RotationMatrix(Quaternion(unit))
    return RigidTransform(R_WO, np.array(entry.numbers("position", 3), float))
