"""`Ros2Link`: ROS 2 through CycloneDDS, without a ROS installation."""

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    read_odometry,
    write_twist,
)


class Ros2Link:
    """A `RosLink` by DDS: a participant that writes cmd_vel and reads odom."""

    def __init__(self, command_topic: str, odometry_topic: str, domain: int):
        """Joins a ROS 2 domain.

        Args:
            command_topic: Topic of the geometry_msgs/msg/Twist commands.
            odometry_topic: Topic of the nav_msgs/msg/Odometry measurements.
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

        self._twist = ros.Twist
        # A reliable writer suits every reader, a best-effort reader every
        # writer.
        reliable = Policy.Reliability.Reliable(max_blocking_time=10_000_000)
        try:
            participant = DomainParticipant(domain)
            self._writer = DataWriter(
                participant,
                Topic(participant, ros.dds_topic(command_topic), ros.Twist),
                qos=Qos(reliable, Policy.History.KeepLast(1)),
            )
            self._reader = DataReader(
                participant,
                Topic(participant, ros.dds_topic(odometry_topic), ros.Odometry),
                qos=Qos(
                    Policy.Reliability.BestEffort, Policy.History.KeepLast(10)
                ),
            )
        except DDSException as error:
            raise RemoSplatError(f"DDS domain {domain}: {error}") from error

    def publish(self, forward: float, yaw_rate: float) -> None:
        """Sends a Twist with these speeds [m/s, rad/s]."""
        self._writer.write(write_twist(self._twist(), forward, yaw_rate))

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        return [
            read_odometry(sample)
            for sample in self._reader.take(N=10)
            if sample.sample_info.valid_data
        ]

    def close(self) -> None:
        """Does nothing: the DDS participant goes with this object."""
