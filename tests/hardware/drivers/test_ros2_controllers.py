"""Joint rates as trajectories: each ends at rest, and they join."""

import numpy as np
import pytest

from remosplat_drake.robot.robot_description import load_robot_description

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
typesys = pytest.importorskip("rosbags.typesys")

from remosplat_drake.hardware.drivers import ros2_messages as ros
from remosplat_drake.hardware.drivers.ros2_controllers import (
    HORIZON,
    TrajectoryStretch,
)

UR5E = load_robot_description("ur5e")
ROWS = [2, 0]


def times(message: ros.JointTrajectory) -> list[float]:
    starts = [point.time_from_start for point in message.points]
    return [start.sec + 1e-9 * start.nanosec for start in starts]


def test_a_trajectory_goes_on_and_brakes_by_the_slowest_joint():
    stretch = TrajectoryStretch(UR5E, ROWS, clock=lambda: 0.0)
    rates = np.array([0.2, 9.0, -0.4, 9.0, 9.0, 9.0])
    q = np.arange(6.0)
    message = stretch.message(rates, q)
    names = [UR5E.arm.joints[i] for i in ROWS]
    assert list(message.joint_names) == names
    first, last = message.points
    np.testing.assert_allclose(first.positions, [2 - 0.04, 0.02])
    np.testing.assert_allclose(first.velocities, [-0.4, 0.2])
    limits = np.array(UR5E.acceleration_limits)[ROWS]
    braking = max(np.array([0.4, 0.2]) / limits)
    assert times(message) == pytest.approx([HORIZON, HORIZON + braking])
    ways = np.subtract(last.positions, first.positions)
    np.testing.assert_allclose(ways, 0.5 * braking * np.array([-0.4, 0.2]))
    assert list(last.velocities) == [0.0, 0.0]


def test_trajectories_join_although_the_arm_is_measured_late():
    """At a constant rate each begins where the one before has led."""
    now = 0.0
    stretch = TrajectoryStretch(UR5E, [0], clock=lambda: now)
    rates, starts = np.array([0.5, 0, 0, 0, 0, 0]), []
    for k in range(20):
        now = 0.01 * k
        late = 0.5 * max(now - 0.03, 0.0)
        message = stretch.message(rates, np.array([late, 0, 0, 0, 0, 0]))
        starts.append(message.points[0].positions[0] - HORIZON * 0.5)
    np.testing.assert_allclose(np.diff(starts), 0.005, atol=1e-12)


def test_an_arm_that_is_held_is_not_run_away_from():
    now = 0.0
    stretch = TrajectoryStretch(UR5E, [0], clock=lambda: now)
    rates, q = np.array([0.5, 0, 0, 0, 0, 0]), np.zeros(6)
    for k in range(1000):
        now = 0.01 * k
        message = stretch.message(rates, q)
    ahead = message.points[0].positions[0] - HORIZON * 0.5
    assert ahead == pytest.approx(0.2 * UR5E.velocity_limits[0])


def test_messages_are_read_by_another_decoder():
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    stretch = TrajectoryStretch(UR5E, ROWS, clock=lambda: 0.0)
    message = stretch.message(np.full(6, 0.1), np.zeros(6))
    name = "trajectory_msgs/msg/JointTrajectory"
    read = store.deserialize_cdr(message.serialize(), name)
    assert list(read.joint_names) == list(message.joint_names)
    assert read.points[0].time_from_start.nanosec == 100_000_000
    assert list(read.points[1].velocities) == [0.0, 0.0]
    assert bytes(store.serialize_cdr(read, name)) == message.serialize()
    twist = ros.TwistStamped(ros.Header(ros.stamp(1_500_000), "base_link"))
    twist.twist.linear.y = 0.25
    name = "geometry_msgs/msg/TwistStamped"
    read = store.deserialize_cdr(twist.serialize(), name)
    assert (read.header.stamp.sec, read.header.stamp.nanosec) == (
        1,
        500_000_000,
    )
    assert read.twist.linear.y == 0.25
