"""`Ros2Link`: ROS 2 through CycloneDDS, without a ROS installation."""

import time

import numpy as np

from remosplat_drake.hardware.drivers.base_stops import BaseStops
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.drivers.ros_base import RosTopics, StopFlags
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    read_odometry,
    read_pose,
    read_transforms,
    write_twist,
)
from remosplat_drake.hardware.wire.localization import BaseFix


class Ros2Link:
    """A `RosLink` by DDS: a participant that writes cmd_vel and reads odom."""

    def __init__(self, topics: RosTopics, domain: int):
        """Joins a ROS 2 domain.

        Args:
            topics: The base's topics.
            domain: The robot's ROS_DOMAIN_ID.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        node = Ros2Node(domain, "the ROS 2 base driver")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._twist, self._topics = ros.Twist, topics
        self._flags = StopFlags(topics)
        self._writer = node.writer(topics.command, ros.Twist)
        self._reader = node.reader(topics.odometry, ros.Odometry)
        self._poses = self._transforms = None
        if topics.localization:
            kind = ros.PoseWithCovarianceStamped
            self._poses = node.reader(topics.localization, kind)
        if topics.transform:
            self._transforms = node.reader("/tf", ros.TFMessage)
        self._stops = {
            field: node.reader(name, ros.Bool)
            for name, field in topics.flags.items()
        }

    def publish(self, forward: float, yaw_rate: float) -> None:
        """Sends a Twist with these speeds [m/s, rad/s]."""
        self._writer.write(write_twist(self._twist(), forward, yaw_rate))

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        return [read_odometry(sample) for sample in taken(self._reader)]

    def fetch_fixes(self) -> list[BaseFix]:
        """Returns the localisations since the last call, oldest first."""
        topics = self._topics
        fixes = [
            read_pose(sample, topics.base_frame)
            for sample in taken(self._poses)
        ]
        deviation = np.array(topics.deviation)
        frames = topics.transform or ("", "")
        for sample in taken(self._transforms):
            fixes += read_transforms(sample, frames, deviation)
        return fixes

    def stops(self, t: float) -> BaseStops:
        """Returns what the topics with flags say at a time t [s]."""
        for field, reader in self._stops.items():
            for sample in taken(reader):
                self._flags.put(field, sample.data, time.monotonic())
        return self._flags.stops(t)

    def close(self) -> None:
        """Does nothing: the DDS participant goes with this object."""
