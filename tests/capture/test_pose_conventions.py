"""Every usual mistake is made on purpose, found and named."""

import dataclasses as dc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.checks.overlap import measure_overlap
from remosplat_drake.capture.checks.pose_conventions import find_mistake

FLIP = np.diag([1.0, -1.0, -1.0, 1.0])


def misread(X_WC: np.ndarray, written_first: bool) -> np.ndarray:
    """Writes quaternions in one order and reads them in the other one."""
    X = X_WC.copy()
    numbers = Rotation.from_matrix(X[:, :3, :3]).as_quat(
        scalar_first=written_first
    )
    read = Rotation.from_quat(numbers, scalar_first=not written_first)
    X[:, :3, :3] = read.as_matrix()
    return X


def scaled(X_WC: np.ndarray, factor: float) -> np.ndarray:
    X = X_WC.copy()
    X[:, :3, 3] *= factor
    return X


MISTAKES = {
    "axes": (lambda X: X @ FLIP, ["OpenGL"]),
    "inverse": (np.linalg.inv, ["world-to-camera"]),
    "inverse OpenGL": (
        lambda X: np.linalg.inv(X @ FLIP),
        ["world-to-camera", "OpenGL"],
    ),
    "inverse OpenGL, read as OpenGL": (
        lambda X: np.linalg.inv(X @ FLIP) @ FLIP,
        ["world-to-camera", "OpenGL"],
    ),
    "xyzw": (lambda X: misread(X, False), ["xyzw read as wxyz"]),
    "wxyz": (lambda X: misread(X, True), ["wxyz read as xyzw"]),
    "xyzw OpenGL": (
        lambda X: misread(X @ FLIP, False) @ FLIP,
        ["xyzw read as wxyz"],
    ),
    "millimetres": (lambda X: scaled(X, 1e3), ["1000 times too large"]),
    "metres": (lambda X: scaled(X, 1e-3), ["1000 times too small"]),
    "depth of TUM": (lambda X: scaled(X, 0.2), ["5 times too small"]),
    "depth to TUM": (lambda X: scaled(X, 5), ["5 times too large"]),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_named(scene_capture, name):
    make, words = MISTAKES[name]
    wrong = dc.replace(scene_capture, X_WC=make(scene_capture.X_WC))
    overlap = measure_overlap(wrong)
    found = find_mistake(wrong, overlap)
    assert found is not None
    mistake, mended = found
    assert all(word in mistake.words for word in words)
    assert ("OpenGL" in mistake.words) == ("OpenGL" in words)
    assert mended.agreement > 0.9


def test_right_poses_have_no_mistake(scene_capture):
    overlap = measure_overlap(scene_capture)
    assert overlap.agreement > 0.99
    assert find_mistake(scene_capture, overlap) is None


def test_no_usual_mistake_explains_random_poses(scene_capture):
    rng = np.random.default_rng(0)
    X_WC = np.tile(np.eye(4), (len(scene_capture), 1, 1))
    X_WC[:, :3, :3] = Rotation.random(len(X_WC), rng=rng).as_matrix()
    X_WC[:, :3, 3] = rng.normal(size=(len(X_WC), 3))
    wrong = dc.replace(scene_capture, X_WC=X_WC)
    assert find_mistake(wrong, measure_overlap(wrong)) is None
