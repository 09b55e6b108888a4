"""`Ros2Arm`: an arm behind ros2_control's velocity controller, without ROS.

ros2_control's `velocity_controllers/JointGroupVelocityController` takes joint
rates as std_msgs/Float64MultiArray, its `joint_state_broadcaster` tells
sensor_msgs/JointState.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.arm_driver import ArmReport

_MOST = 100
"""Number of samples that are taken at once."""


@dc.dataclass(frozen=True)
class ArmTopics:
    """The topics of an arm.

    Attributes:
        command: Topic of the std_msgs/Float64MultiArray commands.
        states: Topic of the sensor_msgs/JointState measurements.
    """

    command: str = "/velocity_controller/commands"
    states: str = "/joint_states"


class Ros2Arm:
    """Commands and states of one arm over DDS; an `ArmLink`."""

    def __init__(self, topics: ArmTopics, joints: Sequence[str], domain: int):
        """Joins a ROS 2 domain.

        Args:
            topics: The arm's topics.
            joints: Names of its joints, in the order of the controller.
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
            raise MissingExtraError("an arm on ROS 2", "ros2") from error
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._joints, self._array = list(joints), ros.Float64MultiArray
        try:
            participant = DomainParticipant(domain)
            reliable = Policy.Reliability.Reliable(max_blocking_time=10_000_000)
            self._writer = DataWriter(
                participant,
                Topic(
                    participant,
                    ros.dds_topic(topics.command),
                    ros.Float64MultiArray,
                ),
                qos=Qos(reliable, Policy.History.KeepLast(1)),
            )
            self._reader = DataReader(
                participant,
                Topic(
                    participant, ros.dds_topic(topics.states), ros.JointState
                ),
                qos=Qos(
                    Policy.Reliability.BestEffort, Policy.History.KeepLast(10)
                ),
            )
        except DDSException as error:
            raise RemoSplatError(f"DDS domain {domain}: {error}") from error

    def command(self, velocity: np.ndarray) -> None:
        """Asks for joint rates, shape (n,) [rad/s]."""
        self._writer.write(self._array(data=velocity.tolist()))

    def fetch(self) -> ArmReport | None:
        """Returns the latest report of all joints; None if there is none.

        A message that lacks one of the joints, or its rate, is left aside:
        several broadcasters may share a topic.
        """
        report = None
        for sample in self._reader.take(N=_MOST):
            if sample.sample_info.valid_data:
                report = read_joint_state(sample, self._joints) or report
        return report

    def close(self) -> None:
        """Does nothing: the DDS participant goes with this object."""


def read_joint_state(message, joints: Sequence[str]) -> ArmReport | None:
    """Reads some joints out of a sensor_msgs/JointState.

    Args:
        message: The message.
        joints: Names of the joints, in the order that is wanted.

    Returns:
        The report; None if a joint is absent or a number is not finite.
    """
    n = len(message.name)
    if len(message.position) != n or len(message.velocity) != n:
        return None
    row = {name: i for i, name in enumerate(message.name)}
    if not set(joints) <= set(row):
        return None
    rows = [row[name] for name in joints]
    q = np.array(message.position, float)[rows]
    v = np.array(message.velocity, float)[rows]
    if not np.isfinite([q, v]).all():
        return None
    stamp = message.header.stamp
    return ArmReport(q, v, stamp.sec + 1e-9 * stamp.nanosec)
