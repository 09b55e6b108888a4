"""The wrist camera's stand-in: its images over the wire, and its pose."""

import math
import time
from collections.abc import Callable

import numpy as np
import pytest
from drake import lcmt_image_array, lcmt_panda_status
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.lcm import LcmSubscriberSystem
from pydrake.systems.sensors import LcmImageArrayToImages
from robot_process import running

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.camera.camera_sim import (
    CameraSim,
    HeardConfiguration,
)
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.hardware.hardware_config import beside
from remosplat_drake.hardware.wire.channels import (
    BASE_STATUS,
    PANDA_STATUS,
    WRIST_CAMERA,
)
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.robot.robot_description import load_robot_description


def arm_status(joints, utime: int = 0) -> bytes:
    message = lcmt_panda_status()
    message.utime = utime
    message.num_joints = len(joints)
    for name in message.__slots__:
        if name.startswith("joint_"):
            setattr(message, name, list(joints))
    return message.encode()


def base(pose, utime: int = 0) -> bytes:
    message = base_status()
    message.utime = utime
    message.pose = list(pose)
    return message.encode()


def test_a_configuration_needs_arm_and_base():
    heard = HeardConfiguration(load_robot_description("frankie"))
    heard.receive(PANDA_STATUS, arm_status(range(7)))
    assert heard.q is None
    heard.receive(BASE_STATUS, base((1, 2, 3)))
    assert heard.q is not None
    np.testing.assert_array_equal(heard.q, [1, 2, 3, *range(7)])


def test_an_arm_without_a_base_waits_for_none():
    heard = HeardConfiguration(load_robot_description("ur5e"))
    assert heard.channels == [PANDA_STATUS]
    assert heard.q is None
    heard.receive(BASE_STATUS, base((1, 2, 3)))
    heard.receive(PANDA_STATUS, arm_status(range(6)))
    np.testing.assert_array_equal(heard.q, range(6))


def test_broken_statuses_are_ignored():
    heard = HeardConfiguration(load_robot_description("frankie"))
    heard.receive(BASE_STATUS, b"nonsense")
    heard.receive(BASE_STATUS, base((0, math.nan, 0)))
    heard.receive(PANDA_STATUS, arm_status(range(6)))
    heard.receive(PANDA_STATUS, arm_status([math.inf] * 7))
    assert heard.q is None


def test_what_moves_begins_when_the_robot_does():
    heard = HeardConfiguration(load_robot_description("frankie"))
    assert heard.time_at(5_000_000) == 0.0
    still = [0, -0.3, 0, -2.2, 0, 2, 0.8]
    for utime in range(1_000_000, 2_000_000, 100_000):
        heard.receive(BASE_STATUS, base((1, 2, 3), utime))
        heard.receive(PANDA_STATUS, arm_status(still, utime))
    trembling = [0.001, *still[1:]]
    heard.receive(PANDA_STATUS, arm_status(trembling, 2_000_000))
    assert heard.time_at(5_000_000) == 0.0
    heard.receive(BASE_STATUS, base((1.01, 2, 3), 3_000_000))
    assert heard.time_at(3_000_000) == 0.0
    assert heard.time_at(5_000_000) == 2.0
    heard.receive(PANDA_STATUS, arm_status([1] * 7, 4_000_000))
    assert heard.time_at(5_000_000) == 2.0


class Viewer:
    """Reads images as the hardware station does."""

    def __init__(self, url: str):
        self._lcm = DrakeLcm(url)
        builder = DiagramBuilder()
        subscriber = builder.AddSystem(
            LcmSubscriberSystem.Make(
                WRIST_CAMERA,
                lcmt_image_array,
                self._lcm,
                use_cpp_serializer=True,
            )
        )
        self._images = builder.AddSystem(LcmImageArrayToImages())
        builder.Connect(
            subscriber.get_output_port(), self._images.get_input_port()
        )
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()

    def ready(self) -> bool:
        """Whether images have come; waits a little."""
        return self._lcm.HandleSubscriptions(10) > 0

    def see(self, take: Callable[[], None]) -> tuple[np.ndarray, np.ndarray]:
        """The next colour and depth image, taken until one comes."""
        end = time.monotonic() + PATIENCE
        take()
        while not self.ready():
            assert time.monotonic() < end
            take()
        self._diagram.ExecuteInitializationEvents(self._context)
        context = self._images.GetMyContextFromRoot(self._context)
        return tuple(
            self._images.GetOutputPort(name).Eval(context).data.copy()
            for name in ("color_image", "depth_image")
        )


def test_images_arrive_and_show_where_the_robot_is(frankie, scene):
    url = free_url()
    viewer = Viewer(url)
    q = np.array([0, 0, 0, *frankie.home])
    config = WristCameraConfig(width=64, height=48)
    camera = CameraSim(config, frankie, scene, [], DrakeLcm(url))
    color, depth = viewer.see(lambda: camera.take(q, 1_000_000, 0.0))
    assert color.shape == (48, 64, 4)
    assert depth.shape == (48, 64, 1)
    away = q - [3.0, *[0.0] * 9]
    assert np.isfinite(depth).any()
    depth_away, end = depth, time.monotonic() + PATIENCE
    # Some that were taken before may still be under way.
    while np.array_equal(depth_away, depth):
        assert time.monotonic() < end
        _, depth_away = viewer.see(lambda: camera.take(away, 2_000_000, 0.0))


@pytest.mark.slow
def test_the_process_sends_images_once_it_hears_a_robot():
    url = free_url()
    lcm, viewer = DrakeLcm(url), Viewer(beside(url))
    with running("camera-sim", "TableReach", "--lcm-url", url, "--rate", "10"):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            lcm.Publish(PANDA_STATUS, arm_status([0, -0.3, 0, -2.2, 0, 2, 0.8]))
            lcm.Publish(BASE_STATUS, base((0, 0, 0)))
            if viewer.ready():
                return
    pytest.fail("no image came")
