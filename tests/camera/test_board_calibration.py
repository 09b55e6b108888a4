"""A rendered ChArUco board, and the mount that its images give."""

import dataclasses as dc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.board_calibration import (
    CharucoBoard,
    find_board,
    fit_board,
)

pytest.importorskip("cv2")
from rendered_board import BOARD, TRUTH, X_WK, board_capture, transform


@pytest.fixture(scope="module")
def capture(rendering):
    return board_capture()


def error(X_FC) -> tuple[float, float]:
    """How far a transform is off [deg, mm]."""
    X = np.linalg.solve(TRUTH, X_FC)
    angle = Rotation.from_matrix(X[:3, :3]).magnitude()
    return np.rad2deg(angle), 1e3 * float(np.linalg.norm(X[:3, 3]))


def views_of(capture, believed):
    """The board's views, the mount being believed to be another one."""
    X_WC = capture.X_WC @ np.linalg.inv(TRUTH) @ believed
    return find_board(BOARD, dc.replace(capture, X_WC=X_WC), believed)


def test_an_unknown_mount_is_found(capture):
    views = views_of(capture, np.eye(4))
    assert len(views) == len(capture)
    fit = fit_board(views)
    degrees, millimetres = error(fit.X_FC)
    assert degrees < 0.03
    assert millimetres < 0.3
    assert fit.residual < 0.4
    # The corners' own scatter tells the size of the error.
    assert millimetres < 5e3 * fit.deviation
    np.testing.assert_allclose(fit.X_WK[:3, 3], X_WK.translation(), atol=5e-4)


def test_an_inaccurate_robot_shows_in_the_residual(capture):
    rng = np.random.default_rng(0)
    views = [
        dc.replace(v, X_WF=v.X_WF @ transform([0] * 3, rng.normal(0, 1e-3, 3)))
        for v in views_of(capture, TRUTH)
    ]
    fit = fit_board(views)
    assert fit.residual > 0.5
    millimetres = error(fit.X_FC)[1]
    assert 1 < millimetres < 3e3 * fit.deviation


def test_a_camera_that_turned_about_one_axis_is_refused(capture):
    views = views_of(capture, TRUTH)
    still = [
        dc.replace(view, X_WF=transform([0, 0, 10 * i], [0.01 * i, 0, 0]))
        for i, view in enumerate(views)
    ]
    with pytest.raises(RemoSplatError, match="must rotate about two axes"):
        fit_board(still)


def test_too_few_images_are_refused(capture):
    with pytest.raises(
        RemoSplatError, match="only 4 images show the board; at least 5"
    ):
        fit_board(views_of(capture, TRUTH)[:4])


def test_another_robots_poses_are_refused(capture):
    views = views_of(capture, TRUTH)
    swapped = [
        dc.replace(view, X_WF=other.X_WF)
        for view, other in zip(views, views[1:] + views[:1], strict=True)
    ]
    with pytest.raises(RemoSplatError, match="pixels off on average"):
        fit_board(swapped)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("charuco", "expected COLUMNSxROWS:SQUARE:MARKER"),
        ("7x5:0.03:0.04", "markers smaller than the squares"),
        ("2x2:0.04:0.03", "three columns and rows"),
        ("7x5:0.04:0.03:DICT_9", "unknown dictionary 'DICT_9'"),
        ("50x50:0.04:0.03", "too few markers"),
    ],
)
def test_an_unusable_board_is_named(text, problem):
    with pytest.raises(RemoSplatError, match=problem):
        CharucoBoard.parse(text).opencv()
    assert CharucoBoard.parse("7x5:0.04:.03").marker == 0.03
