"""`Ros2Robot`: connects the stand-in robot to the topics of ROS 2.

It exchanges LCM messages with the stand-in within this process. On DDS, it has
the topics that a scenario's `!Ros2Arm`, `!Ros2Base` and `!Ros2Hand` name: those
of ros2_control's controllers, of a joint state broadcaster, of a base and of a
gripper.
"""

import time

import numpy as np
from drake import lcmt_panda_status, lcmt_schunk_wsg_status
from pydrake.lcm import DrakeLcm

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.driver_config import Ros2Arm, Ros2Base, Ros2Hand
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.ros_config import BOOL, TRAJECTORY, Tell
from remosplat_drake.hardware.stand_in.faults import (
    CHANNEL,
    encode_request,
    parse_fault,
)
from remosplat_drake.hardware.stand_in.gripper_server import GripperServer
from remosplat_drake.hardware.stand_in.simulated_arm import RobotMode
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.base import encode_base_command
from remosplat_drake.hardware.wire.hand import encode_hand_command
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.panda import encode_panda_command
from remosplat_drake.robot.robot_description import Hand, RobotDescription

_WATCHDOG = 0.1
"""The stand-in's controllers command rest after this time without a command
[s]."""

_MODE_PERIOD = 0.1
"""Time between two messages of stops and modes [s]."""

FAULTS_TOPIC = "/hardware_sim/fault"
"""Topic of std_msgs/String with a fault that begins now, as NAME[=VALUE]."""

_FAULT = "FAULT"
"""Value on the mode's topic while the arm does not follow commands."""


class Ros2Robot:
    """Forwards ROS 2 commands to a stand-in, and its statuses to ROS 2."""

    def __init__(
        self,
        wire: DrakeLcm,
        config: HardwareConfig,
        robot: RobotDescription,
        tell: Tell = lambda news: None,
    ):
        """Joins the robot's domain.

        Args:
            wire: The LCM network of the stand-in, within this process.
            config: The settings of the drivers, with the topics.
            robot: The robot.
            tell: Function that is called with a message when a requested fault
                is unknown.

        Raises:
            FieldError: The driver of the arm or the base is not a driver for
                ROS 2.
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        arm, base = config.arm_driver, config.base_driver
        if not isinstance(arm, Ros2Arm):
            problem = "must be !Ros2Arm for a robot on ROS 2"
            raise FieldError("hardware-sim", "hardware.arm_driver", problem)
        if robot.base is not None and not isinstance(base, Ros2Base):
            problem = "must be !Ros2Base for a robot on ROS 2"
            raise FieldError("hardware-sim", "hardware.base_driver", problem)
        self._wire, self._tell = wire, tell
        heard = [channels.PANDA_STATUS, channels.BASE_STATUS]
        self._inbox = Inbox(wire, [*heard, channels.PANDA_HAND_STATUS])
        self._arm_topics = _ArmTopics(arm, robot)
        self._faults = _fault_reader(arm)
        self._base_topics = None
        if robot.base is not None and isinstance(base, Ros2Base):
            self._base_topics = _BaseTopics(base)
        self._hand_topics = None
        if robot.hand is not None and isinstance(config.hand_driver, Ros2Hand):
            self._hand_topics = _HandTopics(config.hand_driver, robot.hand)

    def step(self) -> None:
        """Forwards new messages in both directions."""
        now, t = time.time(), time.monotonic()
        rates = self._arm_topics.rates(t)
        if rates is not None:
            command = encode_panda_command(rates, now)
            self._wire.Publish(channels.PANDA_COMMAND, command)
        if self._base_topics is not None:
            velocity = self._base_topics.velocity()
            if velocity is not None:
                command = encode_base_command(velocity, now)
                self._wire.Publish(channels.BASE_COMMAND, command)
        if self._hand_topics is not None:
            for width, force in self._hand_topics.commands():
                command = encode_hand_command(width, force, now)
                self._wire.Publish(channels.PANDA_HAND_COMMAND, command)
        for sample in taken(self._faults):
            self._begin(sample.data)
        for channel, data in self._inbox.fetch():
            if channel == channels.PANDA_STATUS:
                self._arm_topics.tell(lcmt_panda_status.decode(data), t)
            elif channel == channels.PANDA_HAND_STATUS:
                if self._hand_topics is not None:
                    self._hand_topics.tell(lcmt_schunk_wsg_status.decode(data))
            elif self._base_topics is not None:
                self._base_topics.tell(base_status.decode(data), t)

    def _begin(self, text: str) -> None:
        """Begins a fault, given as NAME[=VALUE]; reports an unknown name."""
        try:
            fault = parse_fault(f"{text}@0")
        except FieldError as error:
            self._tell(f"{FAULTS_TOPIC}: {error}")
            return
        request = encode_request(fault.name, fault.value)
        self._wire.Publish(CHANNEL, request)


def _fault_reader(config: Ros2Arm):
    node = Ros2Node(config.domain, "the stand-in of a robot on ROS 2")
    from remosplat_drake.hardware.drivers import ros2_messages as ros

    return node.reader(FAULTS_TOPIC, ros.String)


class _ArmTopics:
    """The topics of an arm's controllers, broadcaster and stops."""

    def __init__(self, config: Ros2Arm, robot: RobotDescription):
        node = Ros2Node(config.domain, "the stand-in of a robot on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._ros, self._config, arm = ros, config, list(robot.arm.joints)
        self._names = arm
        self._controllers = []
        for controller in config.controllers:
            rows = [arm.index(name) for name in controller.joints or arm]
            takes = controller.takes == TRAJECTORY
            kind = ros.JointTrajectory if takes else ros.Float64MultiArray
            self._controllers.append(
                (rows, node.reader(controller.topic, kind))
            )
        self._states = node.writer(config.states, ros.JointState)
        if config.description:
            topic = config.description
            self._urdf = node.writer(topic, ros.String, latched=True)
            self._urdf.write(ros.String(_urdf(robot)))
        kinds = {
            "emergency_stop": ros.Bool,
            "mode": getattr(ros, config.mode_type),
        }
        self._stops = {
            field: node.writer(topic, kinds[field])
            for field, topic in config.stops.items()
        }
        self._rates = np.zeros(len(arm))
        self._heard, self._told = -np.inf, -np.inf

    def rates(self, t: float) -> np.ndarray | None:
        """Joint rates of the controllers; None before the first command."""
        for rows, reader in self._controllers:
            for sample in taken(reader):
                self._heard = t
                points = getattr(sample, "points", None)
                rates = points[0].velocities if points else sample.data
                self._rates[rows] = rates
        if np.isinf(self._heard):
            return None
        if t - self._heard > _WATCHDOG:
            self._rates[:] = 0.0
        return self._rates

    def tell(self, status: lcmt_panda_status, t: float) -> None:
        """Sends joint states, and at a lower rate the arm's stops."""
        ros = self._ros
        self._states.write(
            ros.JointState(
                header=ros.Header(stamp=ros.stamp(status.utime)),
                name=self._names,
                position=list(status.joint_position),
                velocity=list(status.joint_velocity),
            )
        )
        if t - self._told < _MODE_PERIOD:
            return
        self._told = t
        mode = status.robot_mode
        if "emergency_stop" in self._stops:
            pressed = mode == RobotMode.USER_STOPPED
            self._stops["emergency_stop"].write(ros.Bool(pressed))
        if "mode" in self._stops:
            obeys = mode == RobotMode.MOVE
            self._stops["mode"].write(self._mode(obeys))

    def _mode(self, obeys: bool):
        """Returns the message of the arm's mode."""
        kind = getattr(self._ros, self._config.mode_type)
        running = self._config.running_modes[0]
        if self._config.mode_type == BOOL:
            return kind((running == "true") == obeys)
        if self._config.mode_type == "Int32":
            return kind(int(running) if obeys else -1)
        return kind(running if obeys else _FAULT)


def _urdf(robot: RobotDescription) -> str:
    """Returns the text of a robot's model, which must be a URDF."""
    path = robot.model_path
    if path.suffix != ".urdf":
        problem = f"{path.name} is not a URDF, which `description` requires"
        raise FieldError(robot.source, "model", problem)
    return path.read_text()


class _BaseTopics:
    """The topics of a base: velocities, odometry and stops."""

    def __init__(self, config: Ros2Base):
        node = Ros2Node(config.domain, "the stand-in of a robot on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._ros, self._config = ros, config
        kind = ros.TwistStamped if config.stamped else ros.Twist
        self._commands = node.reader(config.commands, kind)
        self._odometry = node.writer(config.odometry, ros.Odometry)
        self._flags = {
            field: node.writer(topic, ros.Bool)
            for topic, field in config.flags.items()
        }
        self._told = -np.inf

    def velocity(self) -> np.ndarray | None:
        """The latest velocity, shape (3,); None before the first command."""
        velocity = None
        for sample in taken(self._commands):
            twist = sample.twist if self._config.stamped else sample
            velocity = np.array(
                [twist.linear.x, twist.linear.y, twist.angular.z]
            )
        return velocity

    def tell(self, status: base_status, t: float) -> None:
        """Sends odometry, and at a lower rate the base's stops."""
        ros = self._ros
        message = ros.Odometry(child_frame_id=self._config.base_frame)
        message.header = ros.Header(ros.stamp(status.utime), "odom")
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y, yaw = status.pose
        pose.orientation.z = float(np.sin(0.5 * yaw))
        pose.orientation.w = float(np.cos(0.5 * yaw))
        twist.linear.x, twist.linear.y = status.forward, status.left
        twist.angular.z = status.yaw_rate
        self._odometry.write(message)
        if t - self._told < _MODE_PERIOD:
            return
        self._told = t
        said = {
            "emergency_stop": bool(status.emergency_stop),
            "protective_stop": bool(status.protective_stop),
            "motors_on": status.mode != base_status.STOPPED,
        }
        for field, writer in self._flags.items():
            writer.write(ros.Bool(said[field]))


class _HandTopics:
    """A gripper's commands, by an action or a topic, and its joint states."""

    def __init__(self, config: Ros2Hand, hand: Hand):
        node = Ros2Node(config.domain, "the stand-in of a robot on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._ros, self._share = ros, config.position_share
        self._names = config.joints or hand.joints
        self._server = self._commands = None
        if config.action:
            self._server = GripperServer(node, config.action)
        else:
            self._commands = node.reader(config.commands, ros.GripperCommand)
        self._states = node.writer(config.states, ros.JointState)

    def commands(self) -> list[tuple[float, float]]:
        """The received openings and forces [m, N]."""
        commands = taken(self._commands)
        if self._server is not None:
            commands = self._server.commands()
        return [
            (command.position / self._share, command.max_effort)
            for command in commands
        ]

    def tell(self, status: lcmt_schunk_wsg_status) -> None:
        """Sends joint states, in which each finger has half of the opening."""
        n, width = len(self._names), 1e-3 * status.actual_position_mm
        rate = 1e-3 * status.actual_speed_mm_per_s
        if self._server is not None:
            self._server.tell(width * self._share, rate * self._share)
        self._states.write(
            self._ros.JointState(
                header=self._ros.Header(stamp=self._ros.stamp(status.utime)),
                name=self._names,
                position=[width / n] * n,
                velocity=[rate / n] * n,
                effort=[status.actual_force] * n,
            )
        )
