"""`Ros2Link`: connects to a base on ROS 2, over DDS without ROS."""

import time

import numpy as np

from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.drivers.base_driver import StopFlags
from remosplat_drake.hardware.drivers.base_stops import BaseStops
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    read_odometry,
    read_pose,
    read_transforms,
    transform_deviation,
    write_twist,
)
from remosplat_drake.hardware.ros_config import Ros2BaseTopics
from remosplat_drake.hardware.wire.localization import BaseFix


class Ros2Link:
    """A `BaseLink` as a DDS participant that writes cmd_vel and reads odom."""

    def __init__(self, topics: Ros2BaseTopics):
        """Joins a ROS 2 domain.

        Args:
            topics: The base's topics.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        node = Ros2Node(topics.domain, "a base on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._ros, self._topics = ros, topics
        self._flags = StopFlags(topics)
        kind = ros.TwistStamped if topics.stamped else ros.Twist
        self._writer = node.writer(topics.commands, kind)
        self._reader = node.reader(topics.odometry, ros.Odometry)
        self._poses = self._transforms = None
        if topics.localization:
            kind = ros.PoseWithCovarianceStamped
            self._poses = node.reader(topics.localization, kind)
        if topics.transform:
            self._transforms = node.reader("/tf", ros.TFMessage)
        # A topic that publishes only changes may have published its last
        # message long ago, so the latched message is read, too.
        latched = (False, True) if topics.stop_expiry is None else (False,)
        self._stops = [
            (field, node.reader(name, ros.Bool, latched=kept))
            for kept in latched
            for name, field in topics.flags.items()
        ]

    def publish(self, velocity: np.ndarray) -> None:
        """Sends a velocity, shape (3,) [m/s, m/s, rad/s], as a Twist."""
        twist = write_twist(self._ros.Twist(), velocity)
        if not self._topics.stamped:
            self._writer.write(twist)
            return
        header = self._ros.Header(
            self._ros.stamp(wall_utime()), self._topics.base_frame
        )
        self._writer.write(self._ros.TwistStamped(header, twist))

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
        deviation = transform_deviation(topics)
        for sample in taken(self._transforms):
            map_frame, child = topics.transform
            fixes += read_transforms(sample, (map_frame, child), deviation)
        return fixes

    def stops(self, t: float) -> BaseStops:
        """Returns the stops that the base's topics report at a time t [s]."""
        for field, reader in self._stops:
            for sample in taken(reader):
                self._flags.put(field, sample.data, time.monotonic())
        return self._flags.stops(t)

    def close(self) -> None:
        """Does nothing, since the DDS participant ends with this object."""
