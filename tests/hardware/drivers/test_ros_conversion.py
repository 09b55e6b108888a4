"""Between LCM and ROS: by hand, and against rotations of Drake's."""

import math
from types import SimpleNamespace as Fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.lcm import DrakeLcm
from pydrake.math import RollPitchYaw

from remosplat_drake.hardware.drivers.base_driver import BaseDriver, StopFlags
from remosplat_drake.hardware.drivers.base_stops import BaseStops, merged
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    odometry_problem,
    read_odometry,
    read_pose,
    read_transforms,
    stamp_utime,
    status_of,
    write_twist,
    yaw_of,
)
from remosplat_drake.hardware.ros_config import RosBase
from remosplat_drake.hardware.wire.channels import BASE_STATUS
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.messages.base_status import base_status


@pytest.mark.parametrize(
    ("quaternion", "yaw"),
    [
        ((0, 0, 0, 1), 0.0),
        ((0, 0, 1, 0), math.pi),
        ((0, 0, math.sqrt(0.5), math.sqrt(0.5)), math.pi / 2),
        ((0, 0, -0.2, -0.2), math.pi / 2),
    ],
)
def test_yaw_of_a_quaternion(quaternion, yaw):
    assert yaw_of(*quaternion) == pytest.approx(yaw)


def test_a_quaternion_of_zeros_has_no_yaw():
    assert math.isnan(yaw_of(0, 0, 0, 0))


@settings(max_examples=50)
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3.1, 3.1))
def test_yaw_is_that_of_roll_pitch_yaw(roll, pitch, yaw):
    R = RollPitchYaw(roll, pitch, yaw).ToQuaternion()
    assert yaw_of(R.x(), R.y(), R.z(), R.w()) == pytest.approx(yaw, abs=1e-6)


def test_stamps_of_both_versions():
    assert stamp_utime(Fields(secs=12, nsecs=3_456_789)) == 12_003_456
    assert stamp_utime(Fields(sec=12, nanosec=3_456_789)) == 12_003_456


def test_an_odometry_message_becomes_a_status():
    message = Fields(
        header=Fields(stamp=Fields(secs=1, nsecs=5000)),
        pose=Fields(
            pose=Fields(
                position=Fields(x=1.0, y=2.0, z=0.0),
                orientation=Fields(x=0.0, y=0.0, z=1.0, w=1.0),
            )
        ),
        twist=Fields(
            twist=Fields(linear=Fields(x=0.3, y=0.1), angular=Fields(z=-0.2))
        ),
    )
    status = status_of(read_odometry(message))
    assert odometry_problem(read_odometry(message)) == ""
    assert status.utime == 1_000_005
    assert status.pose == pytest.approx([1.0, 2.0, math.pi / 2])
    assert (status.forward, status.left, status.yaw_rate) == (0.3, 0.1, -0.2)
    assert status.mode == base_status.MOVING
    assert status.battery < 0


def test_a_base_that_stands_is_ready():
    odometry = Odometry(7, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert status_of(odometry).mode == base_status.READY


@pytest.mark.parametrize(
    ("utime", "y", "problem"),
    [(0, 0.0, "header.stamp is 0"), (1, math.nan, "not finite")],
)
def test_odometry_that_cannot_be_used_is_told_once(utime, y, problem):
    odometry = Odometry(utime, (0.0, y, 0.0), (0.0, 0.0, 0.0))
    assert problem in odometry_problem(odometry)
    wire, news = DrakeLcm("memq://"), []
    heard = Inbox(wire, [BASE_STATUS])
    link = Fields(
        fetch=lambda: [odometry],
        fetch_fixes=lambda: [],
        stops=lambda t: BaseStops(),
    )
    driver = BaseDriver(wire, link, tell=news.append)
    driver.step(1, 0.0)
    driver.step(2, 0.01)
    assert len(news) == 1
    assert problem in news[0]
    assert not heard.fetch()


def test_a_twist_has_only_what_a_base_can_do():
    zeros = Fields(x=0.0, y=0.0, z=0.0)
    message = Fields(linear=zeros, angular=Fields(x=0.0, y=0.0, z=0.0))
    write_twist(message, np.array([0.4, 0.2, -0.1]))
    assert (message.linear.x, message.linear.y) == (0.4, 0.2)
    assert (message.angular.z, message.linear.z) == (-0.1, 0.0)
    assert (message.angular.x, message.angular.y) == (0.0, 0.0)


def header(frame: str) -> Fields:
    return Fields(stamp=Fields(sec=12, nanosec=500_000_000), frame_id=frame)


def pose(yaw: float) -> tuple[Fields, Fields]:
    rotation = Fields(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return Fields(x=1.0, y=-2.0, z=0.1), rotation


def test_a_localised_pose_is_read():
    position, rotation = pose(0.5)
    covariance = [float(i == j) * (i + 1) for i in range(6) for j in range(6)]
    covariance[5] = covariance[30] = 0.25  # x with yaw.
    message = Fields(
        header=header("map"),
        pose=Fields(
            pose=Fields(position=position, orientation=rotation),
            covariance=covariance,
        ),
    )
    fix = read_pose(message, "base_link")
    assert fix.pose == pytest.approx([1.0, -2.0, 0.5])
    assert fix.covariance.tolist() == [[1, 0, 0.25], [0, 2, 0], [0.25, 0, 6]]
    assert (fix.frame, fix.child_frame) == ("map", "base_link")
    assert fix.stamp == 12.5


def test_the_wanted_transform_is_found_among_others():
    position, rotation = pose(-0.5)
    transform = Fields(translation=position, rotation=rotation)
    message = Fields(
        transforms=[
            Fields(header=header(a), child_frame_id=b, transform=transform)
            for a, b in (("odom", "base_link"), ("/map", "odom"), ("map", "x"))
        ]
    )
    fixes = read_transforms(message, ("map", "odom"), [0.1, 0.1, 0.2])
    assert [(f.frame, f.child_frame) for f in fixes] == [("/map", "odom")]
    assert fixes[0].pose == pytest.approx([1.0, -2.0, -0.5])
    assert fixes[0].covariance.diagonal() == pytest.approx([0.01, 0.01, 0.04])


def test_stops_are_told_in_the_status():
    odometry = Odometry(1, (0, 0, 0), (0.3, 0, 0))
    status = status_of(odometry, BaseStops(emergency=True, battery=0.5))
    assert status is not None
    assert (status.emergency_stop, status.protective_stop) == (1, 0)
    assert (status.mode, status.battery) == (base_status.STOPPED, 0.5)
    unknown = status_of(odometry, BaseStops(is_unknown=True))
    assert unknown is not None
    assert unknown.mode == base_status.FAULT


def test_any_source_stops_the_base():
    both = merged([BaseStops(protective=True), BaseStops(is_unknown=True)])
    assert both == BaseStops(protective=True, is_unknown=True)
    assert merged([]) == BaseStops()


def test_topics_with_flags():
    topics = RosBase(emergency_stop="/e", motors_on="/m")
    flags = StopFlags(topics)
    assert flags.stops(0.0).is_unknown
    flags.put("emergency_stop", False, 0.0)
    flags.put("motors_on", True, 0.0)
    assert flags.stops(1.0) == BaseStops()
    flags.put("motors_on", False, 1.0)
    assert flags.stops(1.0) == BaseStops(motors_off=True)
    flags.put("emergency_stop", True, 1.5)
    assert flags.stops(2.0).emergency
    # Nothing was heard of the motors any more.
    assert flags.stops(3.4).is_unknown
    assert StopFlags(RosBase()).stops(9.0) == BaseStops()
