"""Converts between the base's LCM messages and ROS 1 or ROS 2 messages.

The messages of both ROS versions have the same fields, except for stamps.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.hardware.drivers.base_stops import FREE, BaseStops, tell
from remosplat_drake.hardware.ros_config import RosBase
from remosplat_drake.hardware.wire.localization import BaseFix
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.packets import from_utime

_STANDSTILL = 1e-3


@dc.dataclass(frozen=True)
class Odometry:
    """The planar part of a base's odometry.

    Attributes:
        utime: Time of measurement [us]; 0 if the message has no stamp.
        pose: x, y and yaw of the base in the map [m, m, rad].
        velocity: Speeds along the base's x and y axes, and turning rate about
            its z axis [m/s, m/s, rad/s].
    """

    utime: int
    pose: tuple[float, float, float]
    velocity: tuple[float, float, float]


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
        (twist.linear.x, twist.linear.y, twist.angular.z),
    )


_PLANAR = np.ix_([0, 1, 5], [0, 1, 5])
"""Indices of x, y and yaw in ROS's 6 by 6 covariances."""


def read_pose(message, child_frame: str) -> BaseFix:
    """Reads a geometry_msgs PoseWithCovarianceStamped of either ROS version.

    Args:
        message: The message; its header names the frame of the pose.
        child_frame: Name of the frame whose pose the message contains. The
            message does not contain this name.
    """
    position = message.pose.pose.position
    rotation = message.pose.pose.orientation
    P = np.array(message.pose.covariance, float).reshape(6, 6)[_PLANAR]
    return _fix(
        message.header, position, rotation, 0.5 * (P + P.T), child_frame
    )


def transform_deviation(topics: RosBase) -> np.ndarray:
    """Returns configured standard deviations of x, y, yaw by /tf, (3,).

    They are in [m, m, rad].
    """
    shift, turn = topics.transform_shift, topics.transform_turn_deg
    return np.array([shift, shift, math.radians(turn)])


def read_transforms(
    message, frames: tuple[str, str], deviation: np.ndarray
) -> list[BaseFix]:
    """Reads the pose of a frame from a tf2_msgs TFMessage of either version.

    Args:
        message: The message, with any number of transforms.
        frames: Names of a frame and of its child. The pose of the child in the
            frame is returned.
        deviation: Standard deviations of x, y and yaw, which the message does
            not contain, shape (3,) [m, m, rad].
    """
    wanted = tuple(name.strip("/") for name in frames)
    return [
        _fix(
            found.header,
            found.transform.translation,
            found.transform.rotation,
            np.diag(np.square(deviation)),
            found.child_frame_id,
        )
        for found in message.transforms
        if wanted
        == (found.header.frame_id.strip("/"), found.child_frame_id.strip("/"))
    ]


def _fix(header, position, rotation, P: np.ndarray, child: str) -> BaseFix:
    yaw = yaw_of(rotation.x, rotation.y, rotation.z, rotation.w)
    stamp = from_utime(stamp_utime(header.stamp))
    pose = np.array([position.x, position.y, yaw])
    return BaseFix(pose, P, stamp, header.frame_id, child)


def write_twist(message, velocity: np.ndarray):
    """Writes a velocity to a geometry_msgs Twist of zeros, and returns it.

    Args:
        message: A Twist of either ROS version.
        velocity: Speeds along the base's x and y axes, and turning rate about
            its z axis, shape (3,) [m/s, m/s, rad/s].
    """
    message.linear.x, message.linear.y, message.angular.z = map(float, velocity)
    return message


def odometry_problem(odometry: Odometry) -> str:
    """Returns the reason why odometry is unusable, or "".

    Odometry without a stamp is unusable, since its age is unknown.
    """
    if not all(map(math.isfinite, (*odometry.pose, *odometry.velocity))):
        return "odometry: a number is not finite"
    if not odometry.utime:
        return "odometry: header.stamp is 0, so that its age is unknown"
    return ""


def status_of(odometry: Odometry, stops: BaseStops = FREE) -> base_status:
    """Converts odometry to the base's status message.

    Odometry does not report stops. Without another source, the flags are 0. The
    controller then detects a stopped base by its motion, which does not follow
    the commands.

    Args:
        odometry: The measurement, for which `odometry_problem` returns "".
        stops: The base's stops.
    """
    status = base_status()
    status.utime = odometry.utime
    status.pose = list(odometry.pose)
    status.forward, status.left, status.yaw_rate = odometry.velocity
    moving = max(map(abs, odometry.velocity)) > _STANDSTILL
    status.mode = base_status.MOVING if moving else base_status.READY
    tell(status, stops)
    return status
