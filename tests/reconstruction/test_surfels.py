"""Surfels: on the surface, facing out of it, finest near the focus."""

import numpy as np
import pytest

from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.report.quality import distance_quality
from remosplat_drake.reconstruction.surfels.surfels import (
    quaternions_onto,
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.quaternions import rotation_matrices


def test_surfels_lie_on_the_surface_and_face_out_of_it(scene, scene_capture):
    surfels = surfels_from_capture(
        scene_capture, count=3000, focus=np.array([1, 0, 0.6]), stride=1
    )
    assert 2000 < len(surfels) <= 3000
    truth = SignedDistanceField(scene).clearances(Spheres.at(surfels.p_WK))
    assert np.percentile(np.abs(truth.distance), 99) < 2e-3
    cosine = -(truth.direction_W * surfels.normal_W).sum(axis=1)
    # Just inside an edge the nearest face may be the other one.
    assert np.percentile(np.abs(cosine), 5) > 0.95
    near = np.linalg.norm(surfels.p_WK - [1, 0, 0.6], axis=1) < 0.6
    far = np.linalg.norm(surfels.p_WK - [1, 0, 0.6], axis=1) > 1.2
    spacing = surfels.spacing
    assert np.median(spacing[near]) < 0.5 * np.median(spacing[far])


@pytest.mark.parametrize("count", [100, 500, 2000])
def test_there_are_never_too_many(scene_capture, count):
    assert count / 2 < len(surfels_from_capture(scene_capture, count)) <= count


def test_untrained_splat_measures_distances(scene, scene_capture):
    splat = splat_of_surfels(
        surfels_from_capture(scene_capture, count=5000, stride=1)
    )
    assert splat.is_surfel
    quality = distance_quality(
        SphereToEllipsoidField(splat),
        SignedDistanceField(scene),
        np.array([0.5, -0.5, 0.5]),
        np.array([1.5, 0.5, 1.0]),
        count=1000,
        nearest=0.1,
    )
    # Twelve small images see the scene in pixels of one to two centimetres.
    assert quality.median < 4e-3
    assert quality.percentile_99 < 0.02


def test_quaternions_turn_z_onto_normals():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[0], normals[1] = [0, 0, 1], [0, 0, -1]
    R = rotation_matrices(quaternions_onto(normals))
    np.testing.assert_allclose(R[:, :, 2], normals, atol=1e-12)
