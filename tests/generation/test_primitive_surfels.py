"""Surfels on primitives: on the surface, facing out, and even."""

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene


def test_surfels_lie_on_the_surface_and_face_outwards(table_scene):
    splat = surfel_splat(table_scene, 20_000)
    truth = SignedDistanceField(table_scene)
    on = truth.clearances(Spheres.at(splat.p_GK))
    assert np.abs(on.per_sphere(len(splat))).max() < 1e-6
    w, x, y, z = splat.quaternions.T
    normal = np.stack(
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], 1
    )
    off = truth.clearances(Spheres.at(splat.p_GK + 0.002 * normal))
    assert (off.per_sphere(len(splat)) > 0).mean() > 0.99


def test_distances_to_surfels_are_those_to_the_scene(table_scene):
    field = SphereToEllipsoidField(surfel_splat(table_scene))
    truth = SignedDistanceField(table_scene)
    rng = np.random.default_rng(0)
    points = rng.uniform([0.5, -1, 0.7], [1.5, 1, 1.2], (500, 3))
    expected = truth.clearances(Spheres.at(points)).per_sphere(500)
    outside = expected > 0.02
    got = field.clearances(Spheres.at(points)).per_sphere(500)
    error = np.abs(got - expected)[outside]
    assert np.median(error) < 2e-3
    assert error.max() < 0.01


def test_hidden_surfaces_have_no_surfels():
    unit, buried = np.ones(3), np.array([0.5, 0.5, 0.5])
    scene = PrimitiveScene(
        boxes=(Box(RigidTransform(), unit), Box(RigidTransform(), buried))
    )
    splat = surfel_splat(scene, 3_000)
    assert np.abs(splat.p_GK).max(axis=1).min() > 0.999
    assert 2_000 < len(splat) < 4_000


def test_surfels_are_the_same_every_time(table_scene):
    a, b = surfel_splat(table_scene, 5_000), surfel_splat(table_scene, 5_000)
    np.testing.assert_array_equal(a.p_GK, b.p_GK)
