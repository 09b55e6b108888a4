"""`Ros2Target`: forwards targets from ROS 2 to a teleoperation."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.drivers.ros_conversion import stamp_utime
from remosplat_drake.hardware.ros_config import Tell
from remosplat_drake.hardware.wire.messages.pose_target import pose_target
from remosplat_drake.hardware.wire.messages.velocity_target import (
    velocity_target,
)


class TargetKind(NamedTuple):
    """A kind of target message: poses or velocities.

    Attributes:
        name: Name of the kind in texts, in the plural.
        message: Name of the ROS message in `ros2_messages`.
        convert: Function that converts a ROS message to an LCM message without
            a stamp.
    """

    name: str
    message: str
    convert: Callable[[Any], pose_target | velocity_target]


class Ros2Target:
    """Forwards stamped messages of a ROS 2 topic to LCM, as targets."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        channel: str,
        topic: str,
        frame: str,
        *,
        kind: TargetKind,
        domain: int | None = None,
        tell: Tell = lambda news: None,
    ):
        """Joins a ROS 2 domain.

        Args:
            lcm: The LCM network.
            channel: LCM channel from which the teleoperation receives targets.
            topic: Topic of the messages.
            frame: Name of the frame that is the world W; messages in other
                frames are ignored.
            kind: Kind of the messages: poses or velocities.
            domain: A ROS_DOMAIN_ID; None takes the value of the environment
                variable, or 0.
            tell: Function that is called with a message when ROS messages are
                unusable.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        node = Ros2Node(domain, "targets from ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._lcm, self._channel, self._frame = lcm, channel, frame
        self._topic, self._kind, self._tell = topic, kind, tell
        self._told: str | None = None
        self._reader = node.reader(topic, getattr(ros, kind.message))

    def step(self) -> None:
        """Forwards new messages."""
        for sample in taken(self._reader):
            target = self._kind.convert(sample)
            target.utime = stamp_utime(sample.header.stamp)
            problem = _problem(sample.header, target, self._frame)
            if not problem:
                self._lcm.Publish(self._channel, target.encode())
            if problem != self._told:
                self._told = problem
                name = self._kind.name
                self._tell(
                    f"{self._topic}: {problem}; such {name} are ignored"
                    if problem
                    else f"{self._topic}: {name} are passed on"
                )


def _problem(header, target: pose_target | velocity_target, frame: str) -> str:
    """Returns the reason why a message is unusable, or ""."""
    named = header.frame_id.strip("/")
    if named != frame.strip("/"):
        return f"frame_id is {named!r}, not {frame!r}"
    if not target.utime:
        return "header.stamp is 0, so that its age is unknown"
    fields = [getattr(target, name) for name in target.__slots__]
    if not all(np.isfinite(field).all() for field in fields):
        return "a number is not finite"
    return ""


def _pose(message) -> pose_target:
    p, r = message.pose.position, message.pose.orientation
    target = pose_target()
    target.position = [p.x, p.y, p.z]
    target.quaternion = [r.w, r.x, r.y, r.z]
    return target


def _velocity(message) -> velocity_target:
    w, v = message.twist.angular, message.twist.linear
    target = velocity_target()
    target.angular = [w.x, w.y, w.z]
    target.linear = [v.x, v.y, v.z]
    return target


POSES = TargetKind("poses", "PoseStamped", _pose)
VELOCITIES = TargetKind("velocities", "TwistStamped", _velocity)
