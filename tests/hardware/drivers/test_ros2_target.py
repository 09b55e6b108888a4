"""Poses and twists over DDS become targets with the age of their source."""

import time

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.drivers.ros2_target import (
    POSES,
    VELOCITIES,
    Ros2Target,
)
from remosplat_drake.teleop.target_stream import (
    decode_pose_target,
    decode_velocity_target,
)

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
typesys = pytest.importorskip("rosbags.typesys")

from remosplat_drake.hardware.drivers import ros2_messages as ros

DOMAIN = 85
UTIME = 1_700_000_000_250_000


def pose(frame: str, utime: int = UTIME, x: float = 1.0) -> ros.PoseStamped:
    message = ros.PoseStamped(ros.Header(ros.stamp(utime), frame))
    message.pose.position = ros.Point(x, 2.0, 3.0)
    # Half a turn about z.
    message.pose.orientation = ros.Quaternion(0.0, 0.0, 1.0, 0.0)
    return message


def passed_on(channel, topic, frame, kind, type, messages):
    """The packets of messages that are sent one after the other, and the news.

    Each is sent until there is news of it.
    """
    wire, packets, news = DrakeLcm("memq://"), [], []
    wire.Subscribe(channel, packets.append)
    target = Ros2Target(
        wire, channel, topic, frame, kind=kind, domain=DOMAIN, tell=news.append
    )
    writer = Ros2Node(DOMAIN, "a test").writer(topic, type)
    end = time.monotonic() + PATIENCE
    for message in messages:
        count = len(news)
        while len(news) == count:
            assert time.monotonic() < end
            writer.write(message)
            target.step()
            wire.HandleSubscriptions(0)
    return packets, [line.removeprefix(f"{topic}: ") for line in news]


def test_a_pose_is_passed_on_and_what_is_none_is_told():
    packets, said = passed_on(
        "POSE_TARGET",
        "/target_pose",
        "map",
        POSES,
        ros.PoseStamped,
        [
            pose("/map"),
            pose("odom"),
            pose("map", utime=0),
            pose("map", x=float("nan")),
        ],
    )
    utime, X_WT = decode_pose_target(packets[0])
    assert utime == UTIME
    np.testing.assert_allclose(X_WT[:3, 3], [1, 2, 3])
    np.testing.assert_allclose(X_WT[:3, :3], np.diag([-1, -1, 1]), atol=1e-12)
    assert said[0] == "poses are passed on"
    assert said[1].startswith("frame_id is 'odom', not 'map'")
    assert said[2].startswith("header.stamp is 0")
    assert said[3].startswith("a number is not finite")


def test_a_twist_is_passed_on_and_what_is_none_is_told():
    turning = ros.Vector3(0, 0, -0.5)
    packets, said = passed_on(
        "VELOCITY_TARGET",
        "/target_twist",
        "world",
        VELOCITIES,
        ros.TwistStamped,
        [
            ros.TwistStamped(
                ros.Header(ros.stamp(UTIME), frame),
                ros.Twist(ros.Vector3(x, 0, 0), turning),
            )
            for frame, x in (
                ("world", 0.2),
                ("tool0", 0.2),
                ("world", float("inf")),
            )
        ],
    )
    utime, V_W = decode_velocity_target(packets[0])
    assert utime == UTIME
    np.testing.assert_array_equal(V_W, [0, 0, -0.5, 0.2, 0, 0])
    assert said[0] == "velocities are passed on"
    assert said[1].startswith("frame_id is 'tool0', not 'world'")
    assert said[2].startswith("a number is not finite; such velocities")


def test_a_pose_is_read_by_another_decoder():
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    name = "geometry_msgs/msg/PoseStamped"
    read = store.deserialize_cdr(pose("map").serialize(), name)
    assert (read.header.frame_id, read.pose.position.z) == ("map", 3.0)
