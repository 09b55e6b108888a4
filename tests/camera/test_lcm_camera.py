"""The real wrist camera's listener, with the stand-in at the other end."""

import threading
import time

import numpy as np
import pytest
from drake import lcmt_panda_status
from patience import PATIENCE
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera import lcm_camera
from remosplat_drake.camera.camera_sim import CameraSim
from remosplat_drake.camera.lcm_camera import LcmCamera
from remosplat_drake.camera.motion_history import MotionHistory
from remosplat_drake.camera.rendered_camera import RenderedCamera
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.hardware.hardware_config import HardwareConfig, beside
from remosplat_drake.hardware.wire.channels import (
    BASE_STATUS,
    PANDA_STATUS,
    WRIST_CAMERA,
)
from remosplat_drake.hardware.wire.messages.base_status import base_status

CONFIG = WristCameraConfig(width=64, height=48)


def arm(q: np.ndarray, utime: int) -> bytes:
    message = lcmt_panda_status()
    message.utime, message.num_joints = utime, len(q)
    for name in message.__slots__:
        if name.startswith("joint_"):
            setattr(message, name, list(q))
    return message.encode()


def base(pose: np.ndarray, utime: int) -> bytes:
    message = base_status()
    message.utime, message.pose = utime, list(pose)
    return message.encode()


def test_between_two_statuses_the_robot_is_between_them():
    history = MotionHistory(7, True)
    for utime in (1_000_000, 1_100_000):
        history.hear_arm(arm(np.full(7, utime * 1e-6), utime))
    # The base turns by 0.2 rad, through pi.
    history.hear_base(base(np.array([0, 0, np.pi - 0.1]), 1_000_000))
    assert history.newest == 1.0
    history.hear_base(base(np.array([1, 0, 0.1 - np.pi]), 1_100_000))
    q = history.at(1.05)
    np.testing.assert_allclose(q, [0.5, 0, np.pi, *[1.05] * 7])


def test_an_unheard_motion_is_refused():
    history = MotionHistory(7, False)
    with pytest.raises(RemoSplatError, match="arm sent no status"):
        history.at(1.0)
    history.hear_arm(b"nonsense")
    history.hear_arm(arm(np.zeros(7), 1_000_000))
    history.hear_arm(arm(np.zeros(7), 2_000_000))
    np.testing.assert_array_equal(history.at(1.5), np.zeros(7))
    history.hear_arm(arm(np.ones(7), 3_000_000))
    with pytest.raises(
        RemoSplatError, match="arm moved, and sent no status around"
    ):
        history.at(2.5)


@pytest.fixture
def patient(monkeypatch):
    """No message is late on a busy computer."""
    monkeypatch.setattr(lcm_camera, "PATIENCE", 60.0)


class Robot:
    """A robot that stands on the wire, with its camera."""

    def __init__(self, frankie, scene, q, url):
        self._frankie, self._scene, self._q, self._url = frankie, scene, q, url
        self._begun, self._end = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self):
        # The renderer belongs to the thread that makes it.
        lcm = DrakeLcm(self._url)
        images = DrakeLcm(beside(self._url))
        camera = CameraSim(CONFIG, self._frankie, self._scene, [], images)
        while not self._end.wait(0.02):
            now = wall_utime()
            lcm.Publish(PANDA_STATUS, arm(self._q[3:], now))
            lcm.Publish(BASE_STATUS, base(self._q[:3], now))
            camera.take(self._q, now, 0.0)
            self._begun.set()

    def __enter__(self):
        self._thread.start()
        assert self._begun.wait(PATIENCE)
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join()


@pytest.mark.usefixtures("patient")
def test_its_frames_are_those_of_the_simulated_camera(frankie, scene):
    q = np.array([0.2, 0.1, 0.3, *frankie.home])
    hardware = HardwareConfig(lcm_url=free_url())
    camera = LcmCamera(CONFIG, frankie, hardware)
    with Robot(frankie, scene, q, hardware.lcm_url):
        frame = camera.frame(np.zeros(10), 100.0)
    expected = RenderedCamera(CONFIG, frankie, scene).frame(q, 100.0)
    assert frame.time is not None and abs(frame.time - time.time()) < PATIENCE
    np.testing.assert_allclose(frame.X_WC, expected.X_WC, atol=1e-9)
    np.testing.assert_array_equal(frame.depth, expected.depth)
    np.testing.assert_array_equal(frame.rgb, expected.rgb)
    np.testing.assert_array_equal(frame.hidden, expected.hidden)


def test_a_camera_without_images_is_silent(frankie, monkeypatch):
    monkeypatch.setattr(lcm_camera, "PATIENCE", 0.05)
    camera = LcmCamera(CONFIG, frankie, HardwareConfig(lcm_url=free_url()))
    with pytest.raises(
        RemoSplatError, match="the wrist camera sends no images"
    ):
        camera.frame(np.zeros(10), 0.0)


@pytest.mark.usefixtures("patient")
def test_an_image_of_another_size_is_refused(frankie, scene):
    q = np.array([0, 0, 0, *frankie.home])
    hardware = HardwareConfig(lcm_url=free_url())
    camera = LcmCamera(WristCameraConfig(), frankie, hardware)
    with (
        Robot(frankie, scene, q, hardware.lcm_url),
        pytest.raises(RemoSplatError, match="sends 64x48 pixels"),
    ):
        camera.frame(q, 0.0)


def test_broken_images_are_counted_and_named(frankie, monkeypatch):
    monkeypatch.setattr(lcm_camera, "PATIENCE", 0.3)
    hardware = HardwareConfig(lcm_url=free_url())
    camera = LcmCamera(CONFIG, frankie, hardware)
    lcm = DrakeLcm(beside(hardware.lcm_url))
    end = time.monotonic() + PATIENCE
    while not camera.broken:
        assert time.monotonic() < end
        lcm.Publish(WRIST_CAMERA, b"nonsense")
        camera.listen()
    assert camera.problem == "WRIST_CAMERA: is not a whole lcmt_image_array"


def test_only_broken_images_are_no_silence(frankie, monkeypatch):
    camera = LcmCamera(CONFIG, frankie, HardwareConfig(lcm_url=free_url()))
    monkeypatch.setattr(lcm_camera, "PATIENCE", 0.05)
    monkeypatch.setattr(
        camera._images, "fetch", lambda: [(WRIST_CAMERA, b"nonsense")]
    )
    with pytest.raises(RemoSplatError, match="broken images in a row"):
        camera.frame(np.zeros(10), 0.0)
