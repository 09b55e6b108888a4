"""Images from librealsense's own software device: no camera is needed."""

import sys
from types import ModuleType

import numpy as np
import pytest
from software_camera import (
    BASELINE,
    HEIGHT,
    UNIT,
    WIDTH,
    SoftwareCamera,
    intrinsics,
)

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.camera.realsense import (
    RealSenseCamera,
    distortion_of,
    from_realsense,
    matrix_of,
    realsense_module,
)
from remosplat_drake.capture.undistortion import distort


def test_without_the_package_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(MissingExtraError, match=r"\[realsense\]"):
        realsense_module()


@pytest.fixture(scope="module")
def rs() -> ModuleType:
    try:
        return realsense_module()
    except MissingExtraError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def frames(rs):
    """A wall at 1 m with a hole, and colours that count columns."""
    camera = SoftwareCamera(rs)
    depth = np.full((HEIGHT, WIDTH), round(1 / UNIT), np.uint16)
    depth[10:20, 30:40] = 0
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    rgb[..., 0] = np.arange(WIDTH)
    yield camera.frames(depth, rgb)
    camera.stop()


def test_depth_is_metric_and_aligned_to_colour(rs, frames):
    image = from_realsense(rs.align(rs.stream.color).process(frames))
    assert image.depth.dtype == np.float32
    known = image.depth > 0
    np.testing.assert_allclose(image.depth[known], 1, rtol=1e-6)
    np.testing.assert_array_equal(image.rgb[5, :, 0], np.arange(WIDTH))
    # From depth to colour, points at 1 m move by f * baseline = 3 columns;
    # columns at the border that the depth camera does not see are unknown.
    row, column = np.argwhere(~known[:, 8:-8]).mean(axis=0)
    np.testing.assert_allclose(row, 14.5, atol=0.6)
    np.testing.assert_allclose(column + 8, 34.5 + 60 * BASELINE, atol=0.6)
    assert 1 <= image.time < 2
    assert image.distortion is None
    np.testing.assert_allclose(image.K[:2, 2], [32, 24])


def test_images_stay_when_librealsense_reuses_its_memory(rs, frames):
    image = from_realsense(rs.align(rs.stream.color).process(frames))
    assert image.rgb.flags.owndata


@pytest.mark.parametrize("model", ["brown_conrady", "inverse_brown_conrady"])
def test_the_lens_is_librealsenses(rs, model):
    """A point of a D455's colour camera, projected by both."""
    lens = intrinsics(rs, model, (-0.055, 0.066, 0.0004, -0.0007, -0.021))
    distortion = distortion_of(lens)
    assert distortion is not None
    K = matrix_of(lens)
    xy = distort(distortion, np.array([0.4, -0.3]))
    expected = rs.rs2_project_point_to_pixel(lens, [0.4, -0.3, 1.0])
    np.testing.assert_allclose(
        K[[0, 1], [0, 1]] * xy + K[:2, 2],
        np.array(expected) + 0.5,
        atol=0.01,
    )


def test_a_fisheye_is_refused(rs):
    lens = intrinsics(rs, "kannala_brandt4", (0.1,) * 5)
    with pytest.raises(RemoSplatError, match="cannot undistort"):
        distortion_of(lens)


def test_a_missing_camera_is_told(rs):
    with pytest.raises(RemoSplatError, match=r"(no|unknown) RealSense camera"):
        RealSenseCamera(serial="000000000000")
