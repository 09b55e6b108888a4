"""Conversion between the base's LCM messages and ROS 1 or ROS 2 messages.

The functions read a ROS message by its fields, which both versions share;
only the stamp has names of its own.
"""

import dataclasses as dc
import math

from remosplat_drake.hardware.wire.messages.base_status import base_status

_STANDSTILL = 1e-3


@dc.dataclass(frozen=True)
class Odometry:
    """The planar part of a base's odometry.

    Attributes:
        utime: When it was measured [us]; 0 if the message has no stamp.
        pose: x, y and yaw of the base in the map [m, m, rad].
        forward: Speed along the base's x axis [m/s].
        yaw_rate: Turning rate about the base's z axis [rad/s].
    """

    utime: int
    pose: tuple[float, float, float]
    forward: float
    yaw_rate: float


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Returns the yaw of a quaternion [rad]; NaN for a zero quaternion."""
    if not x * x + y * y + z * z + w * w > 0:
        return math.nan
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def stamp_utime(stamp) -> int:
    """Returns a ROS 1 or ROS 2 stamp in microseconds, rounded down."""
    if hasattr(stamp, "nanosec"):
        return stamp.sec * 1_000_000 + stamp.nanosec // 1000
    return stamp.secs * 1_000_000 + stamp.nsecs // 1000


def read_odometry(message) -> Odometry:
    """Reads the planar part of a nav_msgs Odometry of either ROS version."""
    position = message.pose.pose.position
    rotation = message.pose.pose.orientation
    yaw = yaw_of(rotation.x, rotation.y, rotation.z, rotation.w)
    twist = message.twist.twist
    return Odometry(
        stamp_utime(message.header.stamp),
        (position.x, position.y, yaw),
        twist.linear.x,
        twist.angular.z,
    )


def write_twist(message, forward: float, yaw_rate: float):
    """Fills a geometry_msgs Twist whose fields are zero, and returns it.

    Args:
        message: A Twist of either ROS version.
        forward: Speed along the base's x axis [m/s].
        yaw_rate: Turning rate about the base's z axis [rad/s].
    """
    message.linear.x = float(forward)
    message.angular.z = float(yaw_rate)
    return message


def status_of(odometry: Odometry, now: int) -> base_status | None:
    """Turns odometry into the base's status message.

    ROS tells nothing of stops and of the battery: the flags stay 0, and a
    base that does not follow its command has to be noticed by its speed.

    Args:
        odometry: The measurement.
        now: Wall clock, for odometry without a stamp [us].

    Returns:
        The status, or None if a number is not finite.
    """
    numbers = (*odometry.pose, odometry.forward, odometry.yaw_rate)
    if not all(map(math.isfinite, numbers)):
        return None
    status = base_status()
    status.utime = odometry.utime or now
    status.pose = list(odometry.pose)
    status.forward = odometry.forward
    status.yaw_rate = odometry.yaw_rate
    speed = max(abs(odometry.forward), abs(odometry.yaw_rate))
    moving = speed > _STANDSTILL
    status.mode = base_status.MOVING if moving else base_status.READY
    status.battery = -1.0
    return status
