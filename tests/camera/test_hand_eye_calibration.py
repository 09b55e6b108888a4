"""Hand-eye transforms made wrong on purpose, and mended."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.hand_eye_calibration import refine_hand_eye
from remosplat_drake.capture.checks.overlap import measure_overlap
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture


def transform(rotation_deg, translation) -> np.ndarray:
    X = np.eye(4)
    X[:3, :3] = Rotation.from_euler("xyz", rotation_deg, True).as_matrix()
    X[:3, 3] = translation
    return X


TRUTH = transform([5, -20, 70], [0.05, -0.02, 0.1])
BELIEVED = transform([7, -22, 71], [0.06, -0.03, 0.11])


@pytest.fixture(scope="module")
def arc(scene):
    """Views of one place, from an arc, with the camera rolled."""
    poses = []
    for i, roll in enumerate(np.deg2rad([0, 30, -40, 20, -10, 45, -30, 10])):
        p_WC = [0.1 + 0.03 * i, -0.6 + 0.15 * i, 0.9 + 0.1 * (i % 3)]
        upright = look_at(np.array(p_WC), np.array([0.9, 0, 0.5]))
        poses.append(
            upright
            @ RigidTransform(RotationMatrix.MakeZRotation(roll), [0, 0, 0])
        )
    return render_capture(scene, poses, 120, 90)


def misplaced(capture):
    """The capture with the poses that the believed transform gives."""
    X_WC = capture.X_WC @ np.linalg.inv(TRUTH) @ BELIEVED
    return dc.replace(capture, X_WC=X_WC)


def error(X_FC) -> tuple[float, float]:
    """How far a transform is off [deg, m]."""
    X = np.linalg.inv(TRUTH) @ X_FC
    angle = Rotation.from_matrix(X[:3, :3]).magnitude()
    return np.rad2deg(angle), float(np.linalg.norm(X[:3, 3]))


def test_a_wrong_transform_is_mended(arc):
    wrong = misplaced(arc)
    assert error(BELIEVED)[0] > 2
    fit = refine_hand_eye(wrong, BELIEVED)
    degrees, metres = error(fit.X_FC)
    assert degrees < 0.01
    assert metres < 2e-4
    assert measure_overlap(wrong).agreement < 0.9
    assert measure_overlap(fit.capture).agreement > 0.99
    np.testing.assert_allclose(fit.capture.X_WC, arc.X_WC, atol=1e-3)


def test_noise_leaves_a_small_error(arc):
    """2 mm at 1 m in each pixel, as good depth cameras have it."""
    rng = np.random.default_rng(0)
    factor = 1 + 0.002 * rng.normal(size=arc.depth.shape)
    depth = (arc.depth * factor).astype(np.float32)
    noisy = dc.replace(misplaced(arc), depth=depth)
    degrees, metres = error(refine_hand_eye(noisy, BELIEVED).X_FC)
    assert degrees < 0.05
    assert metres < 1e-3


def test_turns_about_one_axis_are_refused(scene_capture):
    X_WC = np.array([transform([0, 0, 10 * i], [0, 0, 1]) for i in range(12)])
    with pytest.raises(RemoSplatError, match="rotate about two axes"):
        refine_hand_eye(dc.replace(scene_capture, X_WC=X_WC), np.eye(4))


def test_images_of_different_places_are_refused(scene_capture):
    apart = scene_capture.X_WC.copy()
    apart[:, 0, 3] += 50 * np.arange(len(apart))
    with pytest.raises(RemoSplatError, match="only 0 pairs of 12 images"):
        refine_hand_eye(dc.replace(scene_capture, X_WC=apart), np.eye(4))
