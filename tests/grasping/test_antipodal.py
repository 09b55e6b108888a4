"""Antipodal pairs of bodies where they are known."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.grasping.antipodal import antipodal_pairs
from remosplat_drake.grasping.surface import Surface, surface_of_solid
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.primitive_scene import Box, Cylinder

WIDEST = 0.076


def find(surface, widest=WIDEST, friction=0.4, most=300):
    rng = np.random.default_rng(0)
    return antipodal_pairs(surface, widest, friction, most, rng)


def test_a_box_is_gripped_at_the_faces_that_the_hand_spans():
    """40 and 60 mm fit, 100 mm does not: axes x and y, exactly."""
    box = Box(RigidTransform(), np.array([0.02, 0.03, 0.05]))
    pairs = find(surface_of_solid(box))
    axes = np.abs(pairs.axis).round(9)
    assert {tuple(axis) for axis in axes} == {(1, 0, 0), (0, 1, 0)}
    np.testing.assert_allclose(
        pairs.width, np.where(axes[:, 0] == 1, 0.04, 0.06)
    )
    along = np.einsum("ki,ki->k", pairs.center, pairs.axis)
    np.testing.assert_allclose(along, 0, atol=1e-12)
    assert (pairs.alignment > 0.99).all()


def test_a_can_is_gripped_across_its_axis():
    can = Cylinder(RigidTransform(), 0.033, 0.06)
    pairs = find(surface_of_solid(can))
    np.testing.assert_allclose(pairs.axis[:, 2], 0, atol=1e-9)
    np.testing.assert_allclose(pairs.width, 0.066, rtol=2e-3)
    np.testing.assert_allclose(pairs.center[:, :2], 0, atol=2.1e-3)


def test_a_flat_can_is_gripped_at_its_caps_too():
    pairs = find(surface_of_solid(Cylinder(RigidTransform(), 0.033, 0.02)))
    upright = np.abs(pairs.axis[:, 2]) > 0.5
    np.testing.assert_allclose(pairs.width[upright], 0.04)
    assert upright.any()
    assert not upright.all()


def test_a_balls_axis_goes_through_its_middle():
    rng = np.random.default_rng(1)
    n = rng.normal(size=(3000, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    pairs = find(Surface(0.03 * n, n, 0.002))
    assert len(pairs) > 200
    np.testing.assert_allclose(pairs.width, 0.06, atol=1e-4)
    np.testing.assert_allclose(pairs.center, 0, atol=1.1e-3)


@pytest.mark.parametrize(("friction", "some"), [(0.2, False), (0.6, True)])
def test_a_wedge_needs_friction(friction, some):
    """Two faces at 40 degrees: 20 degrees off, whose tangent is 0.36."""
    tall = 0.04
    base = tall * np.tan(np.radians(20))
    corners = [
        (x, y, z)
        for y in (-0.01, 0.01)
        for x, z in ((-base, 0.0), (base, 0.0), (0.0, tall))
    ]
    hull = ConvexHull(RigidTransform(), np.array(corners))
    pairs = find(surface_of_solid(hull, 0.003), friction=friction)
    sides = np.abs(pairs.axis[:, 0]) > 0.9
    assert sides.any() == some


def test_a_cup_is_gripped_at_its_wall_or_as_a_whole():
    """A box without inside: walls 5 mm thick, 60 mm wide in all."""
    outer = surface_of_solid(
        Box(RigidTransform(), np.array([0.03, 0.03, 0.03]))
    )
    inner = surface_of_solid(
        Box(RigidTransform(), np.array([0.025, 0.03, 0.03]))
    )
    x = np.abs(outer.normals[:, 0]) > 0.5
    np.testing.assert_array_equal(outer.normals[x], inner.normals[: x.sum()])
    cup = Surface(
        np.concatenate([outer.points[x], inner.points[: x.sum()]]),
        np.concatenate([outer.normals[x], -inner.normals[: x.sum()]]),
        outer.spacing,
    )
    widths = np.unique(find(cup).width.round(6))
    np.testing.assert_allclose(widths, [0.005, 0.06])


def test_what_is_too_wide_has_no_grasp():
    cube = Box(RigidTransform(), np.full(3, 0.04))
    assert len(find(surface_of_solid(cube))) == 0


def test_a_mesh_and_its_solid_have_the_same_axes():
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    size = np.array([0.02, 0.05, 0.05])
    hull = ConvexHull(RigidTransform(), size * corners)
    box = find(surface_of_solid(Box(RigidTransform(), size)))
    mesh = find(surface_of_solid(hull))
    for pairs in (box, mesh):
        np.testing.assert_allclose(np.abs(pairs.axis[:, 0]), 1, atol=1e-9)
        np.testing.assert_allclose(pairs.width, 0.04)
