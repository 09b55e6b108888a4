"""Reads and writes scenes in the JSON format of the RMMI benchmark.

`cubes` have a `position` and half-extents `scale`; `cylinders` are upright and
have a `position`, a `radius` and a half-height, which the format spells
`heigth`; `target` and `robot_base` are 4x4 poses in W, row by row. This package
also permits a display `name` for a solid, and a list `objects`, which
`scene/objects/object_file.py` reads.
"""

import json
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_json import read_json_object, shown
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

MAX_LENGTH = 1e6
"""No coordinate or size in a scene may exceed this [m]; its square does not
overflow.
"""

MAX_NAME = 60
"""The name of a solid may have at most this many characters."""

ROTATION_TOLERANCE = 1e-3
"""An entry of R R' - I up to this value counts as rounding of a file's digits.
"""


@reads_file
def read_scene(path: str | Path) -> PrimitiveScene:
    """Reads a scene of the RMMI benchmark from a JSON file.

    The scene is named after the file. `target` and `robot_base` may be absent,
    and are then None.

    Args:
        path: The JSON file, or its `package://` URI.

    Raises:
        FileError: The file cannot be read or is not a JSON object.
        FieldError: A key is missing or unknown, or a value is invalid.

    Example:
        >>> import remosplat_drake as rs
        >>> scene = rs.read_scene("package://remosplat_drake/models/scenes/table/scene.json")
        >>> scene.name
        'scene'
    """
    path = resources.expand(path)
    document = read_json_object(path)
    reader = _Reader(path)
    reader.check_keys(
        document,
        "",
        ("cubes", "cylinders"),
        ("target", "robot_base", "objects"),
    )
    cubes = reader.entries(document, "cubes", ("position", "scale"))
    cylinders = reader.entries(
        document, "cylinders", ("position", "radius", "heigth")
    )
    return PrimitiveScene(
        boxes=tuple(reader.box(*cube) for cube in cubes),
        cylinders=tuple(reader.cylinder(*entry) for entry in cylinders),
        X_WE_target=reader.pose(document, "target"),
        X_WB_start=reader.planar_pose(document, "robot_base"),
        name=path.stem,
    )


def write_rmmi(path: str | Path, scene: PrimitiveScene):
    """Writes a scene in the RMMI benchmark's JSON format, replacing the file.

    Args:
        path: The file to write.
        scene: The scene, which must fit the format.

    Raises:
        FileError: The file cannot be written.
        RemoSplatError: A box is rotated or a cylinder is not upright, which the
            format does not support.
    """
    path = Path(path)
    document: dict[str, object] = {
        "cubes": [
            {
                "position": _position(box),
                "scale": box.half_extents.tolist(),
            }
            | _name(box)
            for box in scene.boxes
        ],
        "cylinders": [
            {
                "position": _position(cylinder),
                "radius": float(cylinder.radius),
                "heigth": float(cylinder.half_height),
            }
            | _name(cylinder)
            for cylinder in scene.cylinders
        ],
    }
    if scene.X_WE_target is not None:
        document["target"] = scene.X_WE_target.GetAsMatrix4().tolist()
    if scene.X_WB_start is not None:
        x, y, yaw = scene.X_WB_start
        X_WB = RigidTransform(RotationMatrix.MakeZRotation(yaw), [x, y, 0.0])
        document["robot_base"] = X_WB.GetAsMatrix4().tolist()
    write_atomically(path, json.dumps(document, indent=1) + "\n")


def _name(primitive: Box | Cylinder) -> dict[str, str]:
    return {"name": primitive.name} if primitive.name else {}


def _position(primitive: Box | Cylinder) -> list[float]:
    R_WP = primitive.X_WP.rotation().matrix()
    axes = slice(0, 3) if isinstance(primitive, Box) else slice(2, 3)
    if not np.allclose(R_WP[:, axes], np.eye(3)[:, axes], atol=1e-12):
        raise RemoSplatError(
            "RMMI scenes can contain only axis-aligned boxes and upright "
            f"cylinders; this solid is rotated: {primitive}"
        )
    return primitive.X_WP.translation().tolist()


class _Reader:
    """Checks values of one file, naming the file and the field."""

    def __init__(self, path: Path):
        self._path = path

    def _reject(self, field: str, problem: str) -> FieldError:
        return FieldError(str(self._path), field, problem)

    def check_keys(
        self,
        value: object,
        field: str,
        required: tuple[str, ...],
        optional: tuple[str, ...] = (),
    ):
        if not isinstance(value, dict):
            raise self._reject(field, "expected an object")
        prefix = f"{field}." if field else ""
        for key in value:
            if key not in (*required, *optional):
                problem = unknown_name("key", key, (*required, *optional))
                raise self._reject(prefix + key, problem)
        for key in required:
            if key not in value:
                raise self._reject(prefix + key, "is missing")

    def entries(
        self, document: dict, key: str, keys: tuple[str, ...]
    ) -> list[tuple[dict, str]]:
        """Yields the objects of a list, each with its field name."""
        if not isinstance(document[key], list):
            raise self._reject(key, "expected a list")
        named = [(e, f"{key}[{i}]") for i, e in enumerate(document[key])]
        for entry, field in named:
            self.check_keys(entry, field, keys, ("name",))
        return named

    def numbers(
        self, value: object, field: str, shape: tuple[int, ...]
    ) -> np.ndarray:
        """Returns finite numbers of a given shape; the parser allows NaN."""
        try:
            array = np.array(value)
        except ValueError:
            array = np.array(None)
        if array.dtype.kind not in "if" or array.shape != shape:
            what = f"numbers of shape {shape}" if shape else "a number"
            raise self._reject(field, f"expected {what}, got {shown(value)}")
        if not np.isfinite(array).all():
            raise self._reject(field, f"not finite: {shown(value)}")
        if not (np.abs(array) <= MAX_LENGTH).all():
            raise self._reject(
                field, f"must be at most {MAX_LENGTH:.0e} m: {shown(value)}"
            )
        return array.astype(float)

    def sizes(
        self, value: object, field: str, shape: tuple[int, ...]
    ) -> np.ndarray:
        array = self.numbers(value, field, shape)
        if not (array > 0).all():
            raise self._reject(field, f"must be positive, got {shown(value)}")
        return array

    def box(self, entry: dict, field: str) -> Box:
        position = self.numbers(entry["position"], f"{field}.position", (3,))
        scale = self.sizes(entry["scale"], f"{field}.scale", (3,))
        return Box(RigidTransform(position), scale, self.name(entry, field))

    def cylinder(self, entry: dict, field: str) -> Cylinder:
        position = self.numbers(entry["position"], f"{field}.position", (3,))
        radius = self.sizes(entry["radius"], f"{field}.radius", ())
        half_height = self.sizes(entry["heigth"], f"{field}.heigth", ())
        return Cylinder(
            RigidTransform(position),
            float(radius),
            float(half_height),
            self.name(entry, field),
        )

    def name(self, entry: dict, field: str) -> str:
        name = entry.get("name", "")
        if not (isinstance(name, str) and len(name) <= MAX_NAME):
            problem = f"expected a text of at most {MAX_NAME} characters"
            raise self._reject(f"{field}.name", problem)
        return name

    def pose(self, document: dict, key: str) -> RigidTransform | None:
        """Reads a 4x4 pose, and removes rounding from its rotation."""
        if key not in document:
            return None
        X = self.numbers(document[key], key, (4, 4))
        R = X[:3, :3]
        is_rotation = (
            np.abs(R @ R.T - np.eye(3)).max() <= ROTATION_TOLERANCE
            and np.linalg.det(R) > 0
        )
        if not is_rotation:
            raise self._reject(key, "its upper left 3x3 is not a rotation")
        if np.abs(X[3] - [0, 0, 0, 1]).max() > ROTATION_TOLERANCE:
            raise self._reject(key, "its last row is not [0, 0, 0, 1]")
        return RigidTransform(
            RotationMatrix.ProjectToRotationMatrix(R), X[:3, 3]
        )

    def planar_pose(
        self, document: dict, key: str
    ) -> tuple[float, float, float] | None:
        """Returns (x, y, yaw) of a pose that is upright on the floor."""
        X_WB = self.pose(document, key)
        if X_WB is None:
            return None
        R_WB = X_WB.rotation().matrix()
        x, y, z = X_WB.translation()
        if abs(R_WB[2, 2] - 1) > ROTATION_TOLERANCE or abs(z) > 1e-3:
            raise self._reject(key, "the base must stand upright on z = 0")
        return float(x), float(y), float(np.arctan2(R_WB[1, 0], R_WB[0, 0]))
