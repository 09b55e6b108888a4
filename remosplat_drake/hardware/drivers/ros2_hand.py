"""`Ros2HandLink`: connects to a gripper on ROS 2, by an action or a topic.

Commands are control_msgs/GripperCommand: goals of an action, which ROS 2's
GripperActionController has, or messages on a topic.
"""

import math
import threading
import time
from collections.abc import Sequence

from remosplat_drake.base.clock import wall_utime
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.hardware.drivers.joint_states import JointStates
from remosplat_drake.hardware.drivers.ros2_gripper_action import (
    ENDED,
    GripperAction,
)
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.ros_config import Ros2HandTopics, Tell
from remosplat_drake.hardware.wire.channels import HAND_STATUS_EXPIRY
from remosplat_drake.hardware.wire.packets import BrokenMessage, is_expired
from remosplat_drake.robot.robot_description import RobotDescription

_CUTOFF = 10.0
"""Cutoff frequency of the filter for the fingers' rates [Hz]. These rates are
not used."""

_STILL = 5e-4
"""The fingers count as stopped if the opening changes by less than this [m]."""

_SETTLED = 0.5
"""A motion counts as ended when the fingers have been still for this time [s].
"""

_LONGEST = 10.0
"""A motion may last for at most this time [s]."""


class Ros2HandLink:
    """Commands and openings of one gripper over DDS; a `HandLink`."""

    def __init__(
        self,
        config: Ros2HandTopics,
        description: RobotDescription,
        tell: Tell = lambda news: None,
    ):
        """Joins a ROS 2 domain.

        Args:
            config: The gripper's topics.
            description: The robot, which names the finger joints.
            tell: Function that is called with a message when joint states are
                unusable.

        Raises:
            FieldError: Neither the driver's settings nor the robot's
                description names finger joints.
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        names = config.joints
        if not names and description.hand:
            names = description.hand.joints
        if not names:
            problem = f"{description.name} has no hand: name the finger joints"
            raise FieldError(description.source, "hand_driver.joints", problem)
        node = Ros2Node(config.domain, "a hand on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._ros, self._config, self._names = ros, config, list(names)
        self._joints = JointStates(names, _CUTOFF)
        self._action = self._commands = None
        if config.action:
            self._action = GripperAction(node, config.action)
        else:
            self._commands = node.writer(config.commands, ros.GripperCommand)
        self._reader = node.reader(config.states, ros.JointState)
        self._tell, self._told = tell, ""
        self._lock = threading.Lock()
        self._latest: tuple[float, float, int] | None = None

    def measure(self) -> tuple[float, float] | None:
        """Returns the fingers' opening and the force of each finger [m, N].

        Without efforts in the joint states, the force is 0. Returns None if the
        latest joint state is older than 0.5 s.
        """
        with self._lock:
            for sample in taken(self._reader):
                self._take(sample)
            latest = self._latest
        if latest is None or is_expired(
            latest[2], wall_utime(), HAND_STATUS_EXPIRY
        ):
            return None
        return latest[:2]

    def go_to(self, width: float, force: float) -> None:
        """Commands the gripper, and returns when the fingers have stopped.

        Args:
            width: Commanded opening [m].
            force: Bound on the gripping force [N].

        Raises:
            RemoSplatError: The opening became unknown, the fingers moved for
                more than 10 s, or the action server did not accept the command.
        """
        self._command(width * self._config.position_share, force)
        end = time.monotonic() + _LONGEST
        before, since = math.nan, time.monotonic()
        while time.monotonic() - since < _SETTLED or self._is_executing():
            measured = self.measure()
            if measured is None:
                raise RemoSplatError(
                    f"{self._config.states}: no usable message for"
                    f" {HAND_STATUS_EXPIRY} s, while the hand moved"
                )
            if time.monotonic() > end:
                raise RemoSplatError(f"the hand moved for {_LONGEST:.0f} s")
            if not abs(measured[0] - before) < _STILL:
                before, since = measured[0], time.monotonic()
            time.sleep(0.01)

    def _is_executing(self) -> bool:
        return self._action is not None and self._action.state() not in ENDED

    def _command(self, position: float, force: float) -> None:
        if self._action is not None:
            self._action.send(position, force)
        if self._commands is not None:
            self._commands.write(self._ros.GripperCommand(position, force))

    def close(self) -> None:
        """Does nothing, since the DDS participant ends with this object."""

    def _take(self, message) -> None:
        """Reads the fingers' positions from a joint state, if present."""
        try:
            report = self._joints.read(message)
        except BrokenMessage as error:
            if str(error) != self._told:
                self._told = str(error)
                self._tell(f"{self._config.states}: {error}")
            return
        if report is not None and report.utime is not None:
            force = _force(message, self._names)
            self._latest = float(report.q.sum()), force, report.utime


def _force(message, names: Sequence[str]) -> float:
    """Greatest effort of the fingers [N]; 0 if it is not measured."""
    if len(message.effort) != len(message.name):
        return 0.0
    efforts = dict(zip(message.name, message.effort, strict=True))
    force = max(abs(efforts[name]) for name in names)
    return force if math.isfinite(force) else 0.0
