"""Objects: their values, and hulls of meshes."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.objects.convex_hull import ConvexHull, read_hull
from remosplat_drake.scene.objects.scene_object import (
    SceneObject,
    check_names,
    find_object,
)
from remosplat_drake.scene.primitive_scene import Cylinder

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


def test_reads_the_hull_of_a_mesh(tmp_path):
    (tmp_path / "part.obj").write_text(TETRAHEDRON)
    vertices = read_hull(tmp_path / "part.obj", 0.1)
    assert np.ptp(vertices, axis=0) == pytest.approx(0.1)
    with pytest.raises(RemoSplatError, match="is not a mesh that Drake reads"):
        read_hull(tmp_path / "part.stl")
