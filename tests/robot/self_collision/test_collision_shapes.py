"""Every kind of collision geometry becomes a convex shape that holds it."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.self_collision.shapes import read_collision_shapes
from remosplat_drake.robot.sphere_model import SphereModel

URDF = """
<robot name="x"><link name="body">
  <inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.5"/><geometry>{}</geometry></collision>
</link></robot>
"""
NONE = SphereModel("none", (), np.zeros((0, 3)), np.zeros(0))


def read(tmp_path, geometry, spheres=NONE):
    path = tmp_path / "x.urdf"
    path.write_text(URDF.format(geometry))
    description = RobotDescription(model=str(path))
    description.source = str(tmp_path / "x.yaml")
    return read_collision_shapes(description, spheres)


def outside(shape, p):
    """How far points stand out of a polyhedron."""
    planes = ConvexHull(shape.vertices).equations
    return (p @ planes[:, :3].T + planes[:, 3]).max(axis=1)


def test_a_box_has_its_corners(tmp_path):
    (shape,) = read(tmp_path, '<box size="0.2 0.4 0.6"/>').shapes
    assert shape.radius == 0.0
    np.testing.assert_allclose(np.ptp(shape.vertices, axis=0), [0.2, 0.4, 0.6])
    center = shape.vertices.mean(axis=0)
    np.testing.assert_allclose(center, [0, 0, 0.5], atol=1e-15)


def test_spheres_and_capsules_are_round(tmp_path):
    (ball,) = read(tmp_path, '<sphere radius="0.3"/>').shapes
    np.testing.assert_array_equal(ball.vertices, [[0, 0, 0.5]])
    assert ball.radius == 0.3
    capsule = '<drake:capsule radius="0.1" length="0.4"/>'
    (capsule,) = read(tmp_path, capsule).shapes
    np.testing.assert_allclose(capsule.vertices, [[0, 0, 0.3], [0, 0, 0.7]])
    assert capsule.radius == 0.1


def test_a_cylinder_lies_in_its_prism(tmp_path):
    (prism,) = read(tmp_path, '<cylinder radius="0.1" length="0.4"/>').shapes
    angle = np.linspace(0, 7, 500)
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.ones(500)])
    rim = rim * [0.1, 0.1, 0.2] + [0, 0, 0.5]
    assert outside(prism, rim).max() <= 1e-12
    assert np.hypot(*prism.vertices.T[:2]).max() < 0.1 * 1.005


def test_an_ellipsoid_lies_in_its_polyhedron(tmp_path):
    (shape,) = read(tmp_path, '<drake:ellipsoid a=".1" b=".2" c=".3"/>').shapes
    v = np.random.default_rng(0).normal(size=(2000, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    assert outside(shape, v * [0.1, 0.2, 0.3] + [0, 0, 0.5]).max() <= 1e-12
    assert ((shape.vertices[:, 2] - 0.5) <= 0.3 * 1.03).all()


def test_a_link_without_geometry_counts_as_its_spheres(tmp_path):
    spheres = SphereModel(
        "x", ("hand", "body"), np.array([[0, 0, 0.1], [9, 9, 9]]), np.ones(2)
    )
    shapes = read(tmp_path, '<box size="1 1 1"/>', spheres)
    assert shapes.links == ("body", "hand")
    assert shapes.by_spheres == ("hand",)
    (ball,) = shapes.of("hand")
    np.testing.assert_array_equal(ball.vertices, [[0, 0, 0.1]])
    assert ball.radius == 1.0


def test_what_has_no_hull_is_refused_in_one_line(tmp_path):
    plane = "<plane><normal>0 0 1</normal></plane>"
    sdf = f"""<sdf version="1.7"><model name="x"><link name="body">
      <collision name="c"><geometry>{plane}</geometry></collision>
    </link></model></sdf>"""
    path = tmp_path / "x.sdf"
    path.write_text(sdf)
    description = RobotDescription(model=str(path))
    description.source = str(tmp_path / "x.yaml")
    with pytest.raises(FieldError, match="'body' collides as a HalfSpace") as e:
        read_collision_shapes(description, NONE)
    assert "\n" not in str(e.value)
