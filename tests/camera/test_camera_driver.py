"""The driver of a RealSense, from injected frames to the wire."""

import numpy as np
import pytest
from drake import lcmt_image_array
from pydrake.lcm import DrakeLcm
from runs import complaint
from software_camera import HEIGHT, UNIT, WIDTH, SoftwareCamera

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.camera import camera_driver
from remosplat_drake.camera.camera_driver import CameraDriver
from remosplat_drake.camera.realsense import from_realsense, realsense_module
from remosplat_drake.camera.rectification import Rectifier
from remosplat_drake.camera.rgbd_image import RgbdImage
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.undistortion import Distortion, distort
from remosplat_drake.hardware.wire.channels import WRIST_CAMERA
from remosplat_drake.hardware.wire.images import decode_images

CONFIG = WristCameraConfig(width=32, height=24, fov_y_deg=20.0)


@pytest.fixture(scope="module")
def rs():
    try:
        return realsense_module()
    except MissingExtraError as error:
        pytest.skip(str(error))


class Injected:
    """A RealSense that shows a wall at 1 m, until its cable is pulled."""

    def __init__(self, rs):
        self._align = rs.align(rs.stream.color)
        self._camera = SoftwareCamera(rs)
        self.is_pulled = False

    def image(self) -> RgbdImage:
        if self.is_pulled:
            raise RemoSplatError("RealSense camera: no image")
        depth = np.full((HEIGHT, WIDTH), round(1 / UNIT), np.uint16)
        rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
        rgb[..., 0] = np.arange(WIDTH)
        frames = self._camera.frames(depth, rgb)
        return from_realsense(self._align.process(frames))

    def stop(self) -> None:
        self._camera.stop()


@pytest.fixture
def wire(monkeypatch):
    monkeypatch.setattr(camera_driver, "RETRY", 0.0)
    lcm, heard = DrakeLcm("memq://"), []
    lcm.Subscribe(WRIST_CAMERA, lambda data: heard.append(bytes(data)))
    return lcm, heard


def test_frames_of_librealsense_arrive_on_the_wire(rs, wire):
    lcm, heard = wire
    driver = CameraDriver(lcm, CONFIG, lambda: Injected(rs))
    driver.step()
    driver.close()
    lcm.HandleSubscriptions(0)
    assert lcmt_image_array.decode(heard[0]).num_images == 2
    images = decode_images(heard[0])
    assert images.depth.shape == (24, 32)
    # The camera's stamp, not that of the driver.
    assert 1 <= images.stamp < 2
    np.testing.assert_allclose(images.depth[:, 8:], 1, rtol=1e-6)
    # The middle columns of both are the same ray.
    assert images.rgb[12, 16, 0] == pytest.approx(32, abs=1)
    assert driver.coverage == 1


def test_a_pulled_cable_is_told_and_the_camera_opened_again(rs, wire):
    lcm, _ = wire
    cameras: list[Injected] = []

    def opened() -> Injected:
        if len(cameras) == 1 and not cameras[0].is_pulled:
            raise RemoSplatError("no RealSense camera is connected")
        cameras.append(Injected(rs))
        return cameras[-1]

    driver = CameraDriver(lcm, CONFIG, opened)
    driver.step()
    cameras[0].is_pulled = True
    driver.step()
    assert driver.problem == "RealSense camera: no image"
    cameras[0].is_pulled = False
    driver.step()
    assert driver.problem == "no RealSense camera is connected"
    cameras[0].is_pulled = True
    driver.step()
    driver.close()
    assert (driver.problem, driver.sent, len(cameras)) == ("", 2, 2)


def test_a_lens_becomes_the_scenarios_pinhole():
    """Depth is a plane that each lens sees by its own rays."""
    lens = Distortion(k1=-0.05, k2=0.06, p1=4e-4, p2=-7e-4)
    K = np.array([[610.0, 0, 325], [0, 612, 238], [0, 0, 1]])
    columns = np.broadcast_to(np.arange(640), (480, 640))
    rows = np.broadcast_to(np.arange(480)[:, None], (480, 640))
    image = RgbdImage(
        rgb=np.zeros((480, 640, 3), np.uint8),
        depth=(1000 * rows + columns).astype(np.float32),
        K=K,
        time=1.0,
        distortion=lens,
    )
    config = WristCameraConfig(width=320, height=240, fov_y_deg=30.0)
    rectifier = Rectifier(config)
    seen = rectifier(image)
    assert rectifier.coverage == 1
    xy = (np.array([100.5, 50.5]) - seen.K[:2, 2]) / seen.K[[0, 1], [0, 1]]
    expected = distort(lens, xy) * K[[0, 1], [0, 1]] + K[:2, 2] - 0.5
    row, column = divmod(seen.depth[50, 100], 1000)
    np.testing.assert_allclose([column, row], expected, atol=0.51)


def test_what_the_lens_does_not_see_is_unknown():
    config = WristCameraConfig(width=32, height=24, fov_y_deg=90.0)
    rectifier = Rectifier(config)
    K = np.array([[100.0, 0, 16], [0, 100, 12], [0, 0, 1]])
    ones = np.ones((24, 32))
    rgb = np.full((24, 32, 3), 9, np.uint8)
    seen = rectifier(RgbdImage(rgb, ones.astype(np.float32), K, 0.0))
    assert 0 < rectifier.coverage < 0.2
    assert (seen.depth == 0).mean() == pytest.approx(1 - rectifier.coverage)
    assert seen.rgb[0, 0].max() == 0


def test_without_a_camera_the_command_says_so(capsys, rs):
    line = complaint(capsys, "camera-driver", "TableReach")
    assert line == "remosplat: no RealSense camera is connected"
    line = complaint(capsys, "camera-driver", "--fps", "0")
    assert "camera-driver: --fps: must be positive" in line
