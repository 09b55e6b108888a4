"""`Ros2Link`: ROS 2 through CycloneDDS, without a ROS installation."""

import time

import numpy as np

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.base_stops import BaseStops
from remosplat_drake.hardware.drivers.ros_base import RosTopics, StopFlags
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    read_odometry,
    read_pose,
    read_transforms,
    write_twist,
)
from remosplat_drake.hardware.wire.localization import BaseFix

_MOST = 100
"""Number of samples that are taken at once."""


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
        try:
            from cyclonedds.core import DDSException, Policy, Qos
            from cyclonedds.domain import DomainParticipant
            from cyclonedds.pub import DataWriter
            from cyclonedds.sub import DataReader
            from cyclonedds.topic import Topic
        except ImportError as error:
            raise MissingExtraError("the ROS 2 base driver", "ros2") from error
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._twist, self._topics = ros.Twist, topics
        self._flags = StopFlags(topics)
        # A reliable writer suits every reader, a best-effort reader every
        # writer.
        reliable = Policy.Reliability.Reliable(max_blocking_time=10_000_000)
        try:
            participant = DomainParticipant(domain)

            def topic(name: str, kind) -> Topic:
                return Topic(participant, ros.dds_topic(name), kind)

            def reader(name: str, kind) -> DataReader:
                history = Policy.History.KeepLast(10)
                qos = Qos(Policy.Reliability.BestEffort, history)
                return DataReader(participant, topic(name, kind), qos=qos)

            self._writer = DataWriter(
                participant,
                topic(topics.command, ros.Twist),
                qos=Qos(reliable, Policy.History.KeepLast(1)),
            )
            self._reader = reader(topics.odometry, ros.Odometry)
            self._poses = self._transforms = None
            if topics.localization:
                kind = ros.PoseWithCovarianceStamped
                self._poses = reader(topics.localization, kind)
            if topics.transform:
                self._transforms = reader("/tf", ros.TFMessage)
            self._stops = {
                field: reader(name, ros.Bool)
                for name, field in topics.flags.items()
            }
        except DDSException as error:
            raise RemoSplatError(f"DDS domain {domain}: {error}") from error

    def publish(self, forward: float, yaw_rate: float) -> None:
        """Sends a Twist with these speeds [m/s, rad/s]."""
        self._writer.write(write_twist(self._twist(), forward, yaw_rate))

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        return [read_odometry(sample) for sample in _taken(self._reader)]

    def fetch_fixes(self) -> list[BaseFix]:
        """Returns the localisations since the last call, oldest first."""
        topics = self._topics
        fixes = [
            read_pose(sample, topics.base_frame)
            for sample in _taken(self._poses)
        ]
        deviation = np.array(topics.deviation)
        frames = topics.transform or ("", "")
        for sample in _taken(self._transforms):
            fixes += read_transforms(sample, frames, deviation)
        return fixes

    def stops(self, t: float) -> BaseStops:
        """Returns what the topics with flags say at a time t [s]."""
        for field, reader in self._stops.items():
            for sample in _taken(reader):
                self._flags.put(field, sample.data, time.monotonic())
        return self._flags.stops(t)

    def close(self) -> None:
        """Does nothing: the DDS participant goes with this object."""


def _taken(reader) -> list:
    """What has come for a reader, oldest first; nothing without one."""
    samples = [] if reader is None else reader.take(N=_MOST)
    return [sample for sample in samples if sample.sample_info.valid_data]
