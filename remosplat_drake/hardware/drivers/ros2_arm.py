"""`Ros2Arm`: an arm behind ros2_control's velocity controller, without ROS.

ros2_control's `velocity_controllers/JointGroupVelocityController` takes joint
rates as std_msgs/Float64MultiArray, its `joint_state_broadcaster` tells
sensor_msgs/JointState. Neither says whether the arm is stopped: other topics
may.
"""

import dataclasses as dc
import time
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.hardware.drivers.arm_driver import ArmReport
from remosplat_drake.hardware.drivers.arm_stops import (
    EMERGENCY_STOP,
    MODE,
    ArmHold,
    ArmStops,
    ArmTopics,
)
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.drivers.ros_conversion import stamp_utime
from remosplat_drake.hardware.wire.packets import BrokenMessage, from_utime


class Ros2Arm:
    """Commands and states of one arm over DDS; an `ArmLink`."""

    def __init__(
        self,
        topics: ArmTopics,
        joints: Sequence[str],
        domain: int,
        on_news: Callable[[str], None] = lambda news: None,
    ):
        """Joins a ROS 2 domain.

        Args:
            topics: The arm's topics.
            joints: Names of its joints, in the order of the controller.
            domain: The robot's ROS_DOMAIN_ID.
            on_news: Called with a line for people when something begins or
                ceases to hold the arm, and when joint states cannot be used.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        node = Ros2Node(domain, "an arm on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._topics, self._joints = topics, list(joints)
        self._array = ros.Float64MultiArray
        self._writer = node.writer(topics.command, ros.Float64MultiArray)
        self._reader = node.reader(topics.states, ros.JointState)
        kinds = {EMERGENCY_STOP: ros.Bool, MODE: getattr(ros, topics.mode_type)}
        self._readers = {
            field: node.reader(topic, kinds[field])
            for field, topic in topics.stops.items()
        }
        self._stops = ArmStops(topics)
        self._on_news = on_news
        self._held, self._broken = "", ""
        self._waits = False

    def command(self, velocity: np.ndarray) -> None:
        """Asks for joint rates.

        An arm that is held is told to rest. Afterwards it is so until rest has
        been asked for: a release starts no motion.

        Args:
            velocity: The rates, shape (n,) [rad/s].
        """
        asked = bool(velocity.any())
        self._waits = bool(self._hold().reason) or (self._waits and asked)
        rates = np.zeros_like(velocity) if self._waits else velocity
        self._writer.write(self._array(data=rates.tolist()))

    def fetch(self) -> ArmReport | None:
        """Returns the latest report of all joints; None if there is none.

        A message that lacks one of the joints is left aside: several
        broadcasters may share a topic. One that cannot be used is told.
        """
        report, hold = None, self._hold()
        for sample in taken(self._reader):
            try:
                report = read_joint_state(sample, self._joints) or report
            except BrokenMessage as error:
                self._tell_broken(f"{self._topics.states}: {error}")
        return report and dc.replace(report, mode=hold.mode)

    def close(self) -> None:
        """Does nothing: the DDS participant goes with this object."""

    def _hold(self) -> ArmHold:
        """What holds the arm now; news are told."""
        for field, reader in self._readers.items():
            for sample in taken(reader):
                self._stops.put(field, sample.data, time.monotonic())
        hold = self._stops.hold(time.monotonic())
        if hold.reason != self._held:
            self._held = hold.reason
            self._on_news(
                f"{hold.reason}; the arm counts as stopped"
                if hold.reason
                else "nothing holds the arm any more"
            )
        return hold

    def _tell_broken(self, problem: str) -> None:
        """Tells what is wrong with joint states, once."""
        if problem != self._broken:
            self._broken = problem
            self._on_news(f"{problem}; no status of the arm is sent")


def read_joint_state(message, joints: Sequence[str]) -> ArmReport | None:
    """Reads some joints out of a sensor_msgs/JointState.

    Args:
        message: The message.
        joints: Names of the joints, in the order that is wanted.

    Returns:
        The report; None if a joint is absent.

    Raises:
        BrokenMessage: A joint has no position or no velocity, or the message
            has no stamp, so that its age is not known.
    """
    row = {name: i for i, name in enumerate(message.name)}
    if not set(joints) <= set(row):
        return None
    utime = stamp_utime(message.header.stamp)
    if not utime:
        raise BrokenMessage("header.stamp is 0, so that its age is not known")
    rows = [row[name] for name in joints]
    q = _numbers("position", message, joints, rows)
    v = _numbers("velocity", message, joints, rows)
    return ArmReport(q, v, from_utime(utime), utime=utime)


def _numbers(
    field: str, message, joints: Sequence[str], rows: Sequence[int]
) -> np.ndarray:
    """Reads a field of some joints; NaN stands for a number that is absent."""
    values = np.array(getattr(message, field), float)
    if len(values) != len(message.name):
        values = np.full(len(message.name), np.nan)
    values = values[rows]
    absent = np.flatnonzero(~np.isfinite(values))
    if len(absent):
        names = ", ".join(joints[int(i)] for i in absent)
        raise BrokenMessage(
            f"no {field} of {names}: the hardware interface of the arm has to"
            f" export the state interface `{field}`"
        )
    return values
