"""Objects: their values, and how files hold them."""

import json

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.objects.convex_hull import ConvexHull, read_hull
from remosplat_drake.scene.objects.object_file import object_entry, read_objects
from remosplat_drake.scene.objects.scene_object import (
    SceneObject,
    check_names,
    find_object,
)
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.scene.rmmi import read_scene

CAN = SceneObject("can", Cylinder(RigidTransform([1, 0, 0.5]), 0.03, 0.06), 0.3)

TETRAHEDRON = """v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def _file(tmp_path, *entries):
    path = tmp_path / "scene.json"
    document = {"cubes": [], "cylinders": [], "objects": list(entries)}
    path.write_text(json.dumps(document))
    return path


def test_moves_as_another_value():
    there = CAN.at(RigidTransform([2, 0, 0.5]))
    assert there.X_WO.translation().tolist() == [2, 0, 0.5]
    assert CAN.X_WO.translation().tolist() == [1, 0, 0.5]
    assert there.name == "can" and there.mass == 0.3
    assert there.corners.tolist() == [[-0.03, -0.03, -0.06], [0.03, 0.03, 0.06]]


def test_hull_keeps_its_outer_points():
    points = [*np.ndindex(2, 2, 2), (0.5, 0.5, 0.5)]
    hull = ConvexHull(RigidTransform([0, 0, 1]), np.array(points, float))
    assert len(hull.vertices) == 8
    assert hull.top == 2.0
    with pytest.raises(RemoSplatError, match="span no volume"):
        ConvexHull(RigidTransform(), np.zeros((5, 3)))


def test_names_are_unique():
    with pytest.raises(RemoSplatError, match="two objects are named 'can'"):
        check_names([CAN, CAN])
    with pytest.raises(RemoSplatError, match="unknown object 'cann'"):
        find_object([CAN], "cann")


def test_round_trip(tmp_path):
    X_WO = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])
    box = SceneObject("box", Box(X_WO, np.array([0.1, 0.2, 0.3])))
    path = _file(tmp_path, object_entry(CAN), object_entry(box))
    can, again = read_objects(path)
    assert can.solid.radius == 0.03 and can.mass == 0.3
    assert again.X_WO.IsNearlyEqualTo(X_WO, 1e-12) and again.mass is None
    assert again.solid.half_extents == pytest.approx([0.1, 0.2, 0.3])
    assert len(read_scene(path)) == 0


def test_reads_the_hull_of_a_mesh(tmp_path):
    (tmp_path / "part.obj").write_text(TETRAHEDRON)
    entry = {
        "name": "part",
        "position": [0, 0, 0],
        "hull": {"file": "part.obj", "scale": 0.1},
    }
    (part,) = read_objects(_file(tmp_path, entry))
    assert part.corners == pytest.approx(np.array([[0.0] * 3, [0.1] * 3]))
    with pytest.raises(RemoSplatError, match="is no mesh that Drake reads"):
        read_hull(tmp_path / "part.stl")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": " "}, r"objects\[0\]\.box: an object needs a name"),
        ({"box": {"size": [1, 1, 0]}}, r"objects\[0\]\.box: half_extents"),
        ({"box": {"sise": [1, 1, 1]}}, "unknown key 'sise'"),
        ({"cylinder": {}}, "give one of box, cylinder, hull, got 2"),
        ({"sphere": {}}, "unknown key 'sphere'"),
        ({"position": [0, 0]}, r"objects\[0\]\.position: expected 3 numbers"),
        ({"mass": 0}, "the mass must be positive"),
    ],
)
def test_bad_entries_end_in_one_line(tmp_path, change, message):
    entry = {"name": "x", "position": [0, 0, 0], "box": {"size": [1, 1, 1]}}
    with pytest.raises(RemoSplatError, match=message) as error:
        read_objects(_file(tmp_path, entry | change))
    assert "\n" not in str(error.value)


def test_two_of_one_name(tmp_path):
    entry = object_entry(CAN)
    with pytest.raises(RemoSplatError, match="two objects are named 'can'"):
        read_objects(_file(tmp_path, entry, entry))
