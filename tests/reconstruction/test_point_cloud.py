"""The paper's start: on the surface, facing the cameras that saw it."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
    initialise,
    joined,
    random_surfels,
    surfels_from_voxels,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene


def offsets(scene: PrimitiveScene, p_WK: np.ndarray) -> np.ndarray:
    truth = SignedDistanceField(scene).clearances(Spheres.at(p_WK))
    return np.abs(truth.per_sphere(len(p_WK)))


@pytest.mark.usefixtures("open3d")
@pytest.mark.smoke
def test_voxels_lie_on_the_surface(scene, scene_capture):
    surfels = surfels_from_voxels(scene_capture, count=3000, voxel=0.02)
    assert len(surfels) == 3000
    # Exact on faces; at edges a voxel's points are averaged around them.
    off = offsets(scene, surfels.p_WK)
    assert np.median(off) < 1e-4
    assert off.max() < 0.02
    assert surfels.spacing.min() > 0


@pytest.mark.usefixtures("open3d")
def test_the_two_sides_of_a_wall_face_their_own_cameras():
    """Three cameras before the wall and one behind it: their mean is before.

    Oriented towards the mean camera, the wall's back would face its front.
    """
    wall = Box(RigidTransform(), np.array([0.05, 0.5, 0.5]))
    poses = [
        look_at(np.array([x, y, 0.0]), np.zeros(3))
        for x, y in ((1, 0.1), (1.1, -0.1), (1.2, 0.2), (-1, 0))
    ]
    capture = render_capture(PrimitiveScene(boxes=(wall,)), poses, 120, 90)
    surfels = surfels_from_voxels(capture, voxel=0.02)
    faces = np.abs(np.abs(surfels.p_WK[:, 0]) - 0.05) < 1e-3
    inner = np.abs(surfels.p_WK[:, 1:]).max(axis=1) < 0.4
    sides = np.sign(surfels.p_WK[:, 0])[faces & inner]
    normal_x = surfels.normal_W[faces & inner, 0]
    assert set(sides) == {-1, 1}
    np.testing.assert_allclose(normal_x, sides, atol=1e-3)


def test_random_points_fill_their_box():
    lower, upper = np.array([0.0, -1, 2]), np.array([1.0, 1, 3])
    surfels = random_surfels(lower, upper, 1000, seed=1)
    assert len(surfels) == 1000
    assert ((surfels.p_WK >= lower) & (surfels.p_WK <= upper)).all()
    np.testing.assert_allclose(
        surfels.p_WK.mean(axis=0), (lower + upper) / 2, atol=0.06
    )
    again = random_surfels(lower, upper, 1000, seed=1)
    np.testing.assert_array_equal(surfels.p_WK, again.p_WK)
    assert len(joined(surfels, again)) == 2000


def test_initialise_adds_the_noise_of_the_third_experiment(scene_capture):
    clean = initialise(scene_capture, InitialisationConfig(count=2000))
    noisy = initialise(
        scene_capture, InitialisationConfig(count=2000, random_points=100)
    )
    assert len(noisy) == len(clean) + 100
    np.testing.assert_array_equal(noisy.p_WK[: len(clean)], clean.p_WK)


@pytest.mark.parametrize(
    ("field", "value"),
    [("method", "voxel"), ("count", 0), ("voxel", 0.0), ("random_points", -1)],
)
def test_an_unusable_configuration_names_its_field(scene_capture, field, value):
    with pytest.raises(FieldError, match=field):
        initialise(scene_capture, InitialisationConfig(**{field: value}))
