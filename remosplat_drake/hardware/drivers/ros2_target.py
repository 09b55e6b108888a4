"""`Ros2Target`: target poses from ROS 2, for a teleoperation."""

import numpy as np
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.drivers.ros_conversion import stamp_utime
from remosplat_drake.hardware.ros_config import Tell
from remosplat_drake.hardware.wire.messages.pose_target import pose_target


class Ros2Target:
    """Passes geometry_msgs/PoseStamped on as `pose_target` messages."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        channel: str,
        topic: str,
        frame: str,
        *,
        domain: int | None = None,
        tell: Tell = lambda news: None,
    ):
        """Joins a ROS 2 domain.

        Args:
            lcm: The LCM network.
            channel: Channel on which the teleoperation listens.
            topic: Topic of the poses.
            frame: The frame that is the world W; poses in another one are left
                aside.
            domain: A ROS_DOMAIN_ID; None takes that of the environment.
            tell: Called with a message when poses are unusable.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        node = Ros2Node(domain, "targets from ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._lcm, self._channel, self._frame = lcm, channel, frame
        self._topic, self._tell = topic, tell
        self._told: str | None = None
        self._reader = node.reader(topic, ros.PoseStamped)

    def step(self) -> None:
        """Passes on new messages."""
        for sample in taken(self._reader):
            problem = self._problem(sample)
            if not problem:
                self._lcm.Publish(self._channel, _target(sample).encode())
            if problem != self._told:
                self._told = problem
                self._tell(
                    f"{self._topic}: {problem}; such poses are left aside"
                    if problem
                    else f"{self._topic}: poses are passed on"
                )

    def _problem(self, message) -> str:
        """Why a pose cannot be used; empty if it can."""
        frame = message.header.frame_id.strip("/")
        if frame != self._frame.strip("/"):
            return f"frame_id is {frame!r}, not {self._frame!r}"
        if not stamp_utime(message.header.stamp):
            return "header.stamp is 0, so that its age is unknown"
        p, r = message.pose.position, message.pose.orientation
        if not np.isfinite([p.x, p.y, p.z, r.x, r.y, r.z, r.w]).all():
            return "a number is not finite"
        return ""


def _target(message) -> pose_target:
    p, r = message.pose.position, message.pose.orientation
    target = pose_target()
    target.utime = stamp_utime(message.header.stamp)
    target.position = [p.x, p.y, p.z]
    target.quaternion = [r.w, r.x, r.y, r.z]
    return target
