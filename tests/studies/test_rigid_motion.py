"""Rigid motions between frames, and what they leave of camera errors."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from apps.studies.rigid_motion import camera_errors, rigid_fit, transformed

X_BA = RigidTransform(RollPitchYaw(0.3, -0.5, 2.0), [1, -2, 0.5])


def test_a_motion_is_found_again():
    p_A = np.random.default_rng(0).standard_normal((20, 3))
    p_B = X_BA.multiply(p_A.T).T
    found = rigid_fit(p_A, p_B)
    np.testing.assert_allclose(found, X_BA.GetAsMatrix4(), atol=1e-12)
    np.testing.assert_allclose(transformed(found, p_A), p_B, atol=1e-12)


def test_a_path_that_lies_elsewhere_as_a_whole_has_its_shape():
    true = np.tile(np.eye(4), (4, 1, 1))
    true[:, :3, 3] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    moved = camera_errors(X_BA.GetAsMatrix4() @ true, true, 1.02)
    assert moved.shape == pytest.approx(0, abs=1e-12)
    # The corner (1, 1) is the farthest one from where it was.
    far = X_BA.multiply(np.array([1.0, 1, 0])) - [1, 1, 0]
    assert moved.position >= np.linalg.norm(far) - 1e-12
    angle = X_BA.rotation().ToAngleAxis().angle()
    assert moved.rotation == pytest.approx(angle)
    assert moved.scale == pytest.approx(0.02)
    # Two corners that leave the plane, crosswise: no motion explains it.
    bent = true.copy()
    bent[[0, 3], 2, 3] = 0.01
    assert camera_errors(bent, true, 1.0).shape == pytest.approx(
        0.005, abs=2e-4
    )
