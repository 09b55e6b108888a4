"""`Ros2ArmLink`: connects to an arm with ros2_control, over DDS.

Controllers receive joint rates or trajectories, and `joint_state_broadcaster`
sends sensor_msgs/JointState. Neither of them reports whether the arm is
stopped, but other topics may do so.
"""

import dataclasses as dc
import time

import numpy as np
from drake import lcmt_panda_status

from remosplat_drake.hardware.drivers.arm_driver import ArmReport
from remosplat_drake.hardware.drivers.arm_stops import ArmHold, ArmStops
from remosplat_drake.hardware.drivers.joint_states import JointStates
from remosplat_drake.hardware.drivers.ros2_controllers import Controllers
from remosplat_drake.hardware.drivers.ros2_description import Ros2Description
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.ros_config import (
    EMERGENCY_STOP,
    MODE,
    Ros2ArmTopics,
    Tell,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.robot_description import RobotDescription


class Ros2ArmLink:
    """Commands and states of one arm over DDS; an `ArmLink`."""

    def __init__(
        self,
        config: Ros2ArmTopics,
        description: RobotDescription,
        tell: Tell = lambda news: None,
    ):
        """Joins a ROS 2 domain.

        Args:
            config: The arm's topics.
            description: The robot, which names the joints in their order.
            tell: Function that is called with a message when a stop of the arm
                begins or ends, when joint states are unusable, and if no topic
                reports stops.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network; or
                a joint has no controller or several.
        """
        node = Ros2Node(config.domain, "an arm on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._controllers = Controllers(node, config.controllers, description)
        self._topic = config.states
        self._reader = node.reader(config.states, ros.JointState)
        self._joints = JointStates(description.arm.joints, config.differentiate)
        kinds = {EMERGENCY_STOP: ros.Bool, MODE: getattr(ros, config.mode_type)}
        # A topic that publishes only changes may have published its last
        # message long ago, so the latched message is read, too.
        latched = (False, True) if config.stop_expiry is None else (False,)
        self._readers = [
            (field, node.reader(topic, kinds[field], latched=kept))
            for kept in latched
            for field, topic in config.stops.items()
        ]
        self._stops = ArmStops(config)
        self._description = None
        if config.description:
            self._description = Ros2Description(
                node, config.description, description
            )
        self._tell = tell
        self._held, self._broken = "", ""
        self._waits = False
        self._q: np.ndarray | None = None
        if not config.emergency_stop:
            tell(
                "the setting `emergency_stop` is empty: the arm's emergency"
                " stop is not known"
            )
        if not config.mode:
            tell(
                "the setting `mode` is empty: the arm's mode is not known, "
                "and assumed to be `move`"
            )

    def command(self, velocity: np.ndarray) -> None:
        """Sends joint rates to the controllers.

        A stopped arm is commanded to rest. When the stop is released, rates are
        sent only after a command of rest has come, so that the release does not
        start a motion.

        Args:
            velocity: The rates, shape (n,) [rad/s].
        """
        asked = bool(velocity.any())
        self._waits = bool(self._hold().reason) or (self._waits and asked)
        rates = np.zeros_like(velocity) if self._waits else velocity
        self._controllers.command(rates, self._q)

    def fetch(self) -> ArmReport | None:
        """Returns the latest report of all joints; None if there is none.

        A message without one of the joints is ignored, since several
        broadcasters may share a topic. An unusable message is reported.
        """
        report, hold = None, self._hold()
        for sample in taken(self._reader):
            try:
                report = self._joints.read(sample) or report
            except BrokenMessage as error:
                self._tell_broken(f"{self._topic}: {error}")
        if report is None:
            return None
        self._q = report.q
        return dc.replace(report, mode=hold.mode)

    def close(self) -> None:
        """Does nothing, since the DDS participant ends with this object."""

    def _hold(self) -> ArmHold:
        """Returns the present stop of the arm; reports changes of it."""
        for field, reader in self._readers:
            for sample in taken(reader):
                self._stops.put(field, sample.data, time.monotonic())
        hold = self._stops.hold(time.monotonic())
        problem = self._description and self._description.problem()
        if problem and not hold.reason:
            hold = ArmHold(lcmt_panda_status.kOther, problem)
        if hold.reason != self._held:
            self._held = hold.reason
            self._tell(
                f"{hold.reason}; the arm counts as stopped"
                if hold.reason
                else "the arm is no longer stopped"
            )
        return hold

    def _tell_broken(self, problem: str) -> None:
        """Reports the fault of joint states, once."""
        if problem != self._broken:
            self._broken = problem
            self._tell(f"{problem}; no status of the arm is sent")
