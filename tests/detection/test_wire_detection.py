"""Cameras on the wire, and what is told of movers there."""

import dataclasses as dc
import time

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from room import CONFIG, ROOM, ball, known_room
from wire_messages import arm_message, base_message

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.base.errors import FieldError
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.simulated.wire_camera import WireCamera
from remosplat_drake.detection.wire_detection import WireDetection
from remosplat_drake.hardware.hardware_config import HardwareConfig, beside
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.images import decode_depth, encode_depth
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.movers import decode_movers
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.mover import Movers

CAMERA = DetectionCameraConfig(
    name="left",
    translation=[-0.6, -1.4, 1.4],
    look_at=[0.5, 0, 0.7],
    width=80,
    height=60,
)


@pytest.fixture(scope="module")
def robot():
    return load_robot("frankie")


class Ball:
    """A ball that swings forth and back, as a track."""

    def movers(self, time):
        p_W = [0.3, 0.3 * np.sin(time), 0.9]
        return ball(p_W, [0.0, 0.3 * np.cos(time), 0.0]).movers


class Rig:
    """The process's insides, a camera, a robot's statuses, and a listener."""

    def __init__(self, robot, cameras=(CAMERA,)):
        url = free_url()
        self.hardware = HardwareConfig(lcm_url=url)
        self.lcm, self.camera_lcm = DrakeLcm(url), DrakeLcm(beside(url))
        self.detection = WireDetection(
            cameras, robot, known_room(), CONFIG, self.hardware
        )
        self.camera = WireCamera(CAMERA, robot, ROOM, [Ball()], self.camera_lcm)
        self.inbox = Inbox(self.lcm, [channels.MOVERS])
        self.q = robot.q_home.copy()
        self.q[0] -= 0.6
        self.told: list[Movers] = []
        self.start = wall_utime()

    @property
    def movers(self) -> Movers:
        """What was told last."""
        return self.told[-1]

    def say(self):
        """Sends the statuses of a robot that stands."""
        now, q = wall_utime(), self.q.tolist()
        arm = arm_message(utime=now, joint_position=q[3:])
        self.lcm.Publish(channels.PANDA_STATUS, arm)
        base = base_message(utime=now, pose=q[:3])
        self.lcm.Publish(channels.BASE_STATUS, base)

    def until(self, done, take=True):
        """Goes on until something is so."""
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end, self.detection.problems
            self.say()
            if take:
                now = wall_utime()
                self.camera.take(self.q, now, (now - self.start) / 1e6)
            self.detection.step(0.005)
            for _, data in self.inbox.fetch(0.001):
                self.told.append(decode_movers(data))


def test_a_ball_before_a_camera_is_told_of_on_the_wire(robot):
    rig = Rig(robot)
    rig.until(lambda: rig.told and len(rig.movers))
    assert rig.movers.cameras[0].name == "left"
    assert not rig.movers.cameras[0].problem
    apart = rig.movers.movers[0].X_WM.translation() - [0.3, 0, 0.9]
    assert np.abs(apart).max() < 1.0
    assert abs(time.time() - rig.movers.stamp) < PATIENCE
    before = rig.movers.cameras[0].seen
    wrong_size = encode_depth(np.ones((4, 4)), wall_utime())
    broken(rig, wrong_size, "4x4 pixels")
    assert rig.movers.cameras[0].seen - before < PATIENCE
    seen = rig.movers.cameras[0].seen
    broken(rig, b"nonsense", "not a whole")
    assert rig.movers.cameras[0].seen == seen, "known until then"
    old = encode_depth(np.ones((60, 80)), wall_utime() - 2_000_000)
    broken(rig, old, "s old")


def broken(rig: Rig, data: bytes, problem: str) -> None:
    """Sends something else than an image until the listener knows of it."""

    def told() -> bool:
        rig.camera_lcm.Publish(CAMERA.channel_name, data)
        return problem in rig.movers.cameras[0].problem

    rig.until(told, take=False)


def test_nothing_is_told_before_all_cameras_are_heard(robot):
    other = dc.replace(CAMERA, name="right")
    rig = Rig(robot, [CAMERA, other])
    rig.until(lambda: rig.detection.missing == ["right"])
    assert not rig.told
    assert rig.detection.told == 0


def test_without_statuses_an_image_tells_nothing(robot):
    rig = Rig(robot)
    rig.say = lambda: None
    rig.until(
        lambda: "sent no status" in rig.detection.problems.get("left", "")
    )
    assert rig.detection.told == 0


def test_depths_survive_the_wire_to_a_millimetre():
    depth = np.random.default_rng(0).uniform(0.3, 5, (12, 16))
    depth[0, 0], depth[0, 1] = 0.0, np.inf
    found, stamp = decode_depth(encode_depth(depth, 12_345_678))
    assert stamp == 12.345678
    known = np.isfinite(depth)
    assert found[known] == pytest.approx(depth[known], abs=6e-4)
    assert found[0, 0] == 0
    assert found[0, 1] > 65
    with pytest.raises(BrokenMessage):
        decode_depth(b"nonsense")


def test_a_camera_looks_where_it_is_told():
    X_WC = CAMERA.X_FC
    assert CAMERA.look_at is not None
    ahead = np.subtract(CAMERA.look_at, CAMERA.translation)
    at_C = X_WC.rotation().inverse().multiply(ahead)
    assert at_C == pytest.approx([0, 0, np.linalg.norm(ahead)])
    assert X_WC.rotation().matrix()[2, 1] < 0, "y is down"
    down = dc.replace(CAMERA, translation=[0, 0, 2.0], look_at=[0, 0, 0])
    assert down.X_FC.rotation().matrix()[:, 2] == pytest.approx([0, 0, -1])


@pytest.mark.parametrize(
    "wrong",
    [
        {"look_at": [0.0, 0, 1], "rpy_deg": [0.0, 0, 0]},
        {"look_at": [0.0, 0, 1], "frame": "wrist_camera"},
        {"look_at": [0.0, 0, 0]},
        {"max_depth": 0.1},
    ],
)
def test_a_camera_that_cannot_be_is_refused(wrong):
    with pytest.raises(FieldError):
        DetectionCameraConfig(**wrong)
