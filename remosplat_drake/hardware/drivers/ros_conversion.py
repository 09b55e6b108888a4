"""Between the base's LCM messages and ROS ones, of either version.

The functions read a ROS message by its fields, which both versions share;
only the stamp has names of its own.
"""

import dataclasses as dc
import math

from remosplat_drake.hardware.wire.messages.base_status import base_status

_STANDSTILL = 1e-3


@dc.dataclass(frozen=True)
class Odometry:
    """What a base's odometry says.

    Attributes:
        utime: When it was measured; 0 if the message has no stamp [us].
        pose: x, y, yaw in the map [m, m, rad].
        forward: Speed along the base's x axis [m/s].
        yaw_rate: Rate about its z axis [rad/s].
    """

    utime: int
    pose: tuple[float, float, float]
    forward: float
    yaw_rate: float


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Yaw of a rotation given as a quaternion [rad]; nan if it is none."""
    if not x * x + y * y + z * z + w * w > 0:
        return math.nan
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def stamp_utime(stamp) -> int:
    """Microseconds of a ROS 1 or ROS 2 stamp, rounded down."""
    if hasattr(stamp, "nanosec"):
        return stamp.sec * 1_000_000 + stamp.nanosec // 1000
    return stamp.secs * 1_000_000 + stamp.nsecs // 1000


def read_odometry(message) -> Odometry:
    """The planar part of a nav_msgs Odometry."""
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
    """Fills a geometry_msgs Twist whose fields are zero; returns it."""
    message.linear.x = float(forward)
    message.angular.z = float(yaw_rate)
    return message


def status_of(odometry: Odometry, now: int) -> base_status | None:
    """The status that an odometry message amounts to.

    ROS tells nothing of stops and of the battery: the flags stay 0, and a
    base that does not follow its command has to be noticed by its speed.

    Args:
        odometry: The message.
        now: Wall clock, for messages without a stamp [us].

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
