"""The topics of a robot on ROS 1 or ROS 2, as data."""

import dataclasses as dc
import re
from collections.abc import Callable, Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf

Tell = Callable[[str], None]
"""Prints a message."""

STRING, INT32, BOOL = "String", "Int32", "Bool"
MODE_TYPES = (STRING, INT32, BOOL)
"""Messages of std_msgs that may contain an arm's mode."""

VELOCITIES, TRAJECTORY = "velocities", "trajectory"
COMMANDS = (VELOCITIES, TRAJECTORY)
"""Commands of ros2_control's controllers: Float64MultiArray, or
JointTrajectory."""

EMERGENCY_STOP, MODE = "emergency_stop", "mode"

Topic = Annotated[str, Len(1, 256)]
"""Name of a ROS topic."""

StopExpiry = Annotated[float, Interval(gt=0, le=3600)] | None
"""Silence after which a topic is unknown [s]; None for topics that publish
changes only."""

Domain = Annotated[int, Interval(ge=0, le=232)] | None
"""A ROS_DOMAIN_ID; None takes that of the environment, or 0."""


@dc.dataclass
class Ros2Controller(Config):
    """A controller of ros2_control that moves joints of the arm."""

    # Topic of its commands.
    topic: Topic = "/velocity_controller/commands"
    # What it takes: `velocities` is the Float64MultiArray of a
    # JointGroupVelocityController, `trajectory` the JointTrajectory of a
    # JointTrajectoryController.
    takes: Annotated[str, OneOf(COMMANDS)] = VELOCITIES
    # Its joints in its order; empty: all of the arm in the description's order.
    joints: list[str] = dc.field(default_factory=list)


@dc.dataclass
class Ros2ArmTopics(Config):
    """Commands and topics of an arm behind ros2_control."""

    # The robot's ROS_DOMAIN_ID; absent: that of the environment, or 0.
    domain: Domain = None
    # The controllers, which together move every joint of the arm once.
    controllers: Annotated[list[Ros2Controller], Len(1, 16)] = dc.field(
        default_factory=lambda: [Ros2Controller()]
    )
    # Topic of the sensor_msgs/JointState measurements.
    states: Topic = "/joint_states"
    # Topic of the robot's URDF, std_msgs/String, as /robot_description: the
    # arm is stopped unless its joints, limits and axes agree with our model;
    # empty: not compared.
    description: str = ""
    # Cutoff frequency of the low pass behind differentiated positions, for
    # joint states without velocities; absent: these cannot be used [Hz]. Such
    # velocities lag by 1 / (2 pi cutoff) and half a period of the statuses.
    differentiate: Annotated[float, Interval(ge=1, le=200)] | None = None
    # Topic of std_msgs/Bool: whether an emergency stop is latched; empty:
    # not known.
    emergency_stop: str = ""
    # Topic that says in which mode the arm is; empty: not known.
    mode: str = ""
    # Its messages in std_msgs: `String`, `Int32` or `Bool`.
    mode_type: Annotated[str, OneOf(MODE_TYPES)] = STRING
    # What it says while the arm obeys, as text: `"true"` for a Bool, `"7"` for
    # an Int32.
    running_modes: Annotated[list[str], Len(0, 32)] = dc.field(
        default_factory=list
    )
    # Silence after which the last two topics count as a stop [s]; null for
    # topics that tell changes only.
    stop_expiry: StopExpiry = 2.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for modes that contradict each other."""
        if bool(self.running_modes) != bool(self.mode):
            yield "running_modes", "belongs with `mode`: give both, or neither"
        for i, mode in enumerate(self.running_modes):
            field = f"running_modes[{i}]"
            if self.mode_type == BOOL and mode not in ("true", "false"):
                yield field, f"{mode!r}: a {BOOL} is true or false"
            whole = re.fullmatch(r"0|-?[1-9]\d*", mode)
            if self.mode_type == INT32 and not whole:
                yield field, f"{mode!r}: an {INT32} is a whole number"

    @property
    def stops(self) -> dict[str, str]:
        """The topics that say whether the arm may move, by their fields."""
        topics = {EMERGENCY_STOP: self.emergency_stop, MODE: self.mode}
        return {field: topic for field, topic in topics.items() if topic}


@dc.dataclass
class Ros2HandTopics(Config):
    """Commands and topics of a gripper on ROS 2."""

    # The robot's ROS_DOMAIN_ID; absent: that of the environment, or 0.
    domain: Domain = None
    # Topic of the control_msgs/GripperCommand commands.
    commands: Topic = "/gripper_controller/command"
    # Topic of the sensor_msgs/JointState measurements.
    states: Topic = "/joint_states"
    # Finger joints whose positions add up to the opening; empty: those of the
    # robot's description.
    joints: list[str] = dc.field(default_factory=list)
    # Position of a command per opening: 1 for the opening itself, 0.5 for the
    # way of each of two fingers.
    position_share: Annotated[float, Interval(gt=0, le=100)] = 1.0


@dc.dataclass
class RosBase(Config):
    """Settings that bases on ROS 1 and ROS 2 share: their topics."""

    # Topic of the velocity commands.
    commands: Topic = "/cmd_vel"
    # Topic of the nav_msgs/Odometry measurements.
    odometry: Topic = "/odom"
    # Topic of geometry_msgs/PoseWithCovarianceStamped: the base in the map,
    # such as /amcl_pose; empty: none.
    localization: str = ""
    # The frame whose pose that is.
    base_frame: str = "base_link"
    # Names of the map's frame and of the one that /tf locates in it, the
    # odometry's or the base's; empty: /tf is not asked.
    transform: Annotated[list[str], Len(0, 2)] = dc.field(default_factory=list)
    # Standard deviation of the position that /tf tells [m].
    transform_shift: Annotated[float, Interval(gt=0, le=1)] = 0.05
    # Standard deviation of the heading that /tf tells [deg].
    transform_turn_deg: Annotated[float, Interval(gt=0, le=45)] = 2.0
    # Topic of std_msgs/Bool: whether an emergency stop is latched; empty:
    # not known.
    emergency_stop: str = ""
    # Topic of std_msgs/Bool: whether the scanner holds the base; empty:
    # not known.
    protective_stop: str = ""
    # Topic of std_msgs/Bool: whether the motors are on; empty: not known.
    motors_on: str = ""
    # Silence after which these three count as a stop [s]; null for topics that
    # tell changes only.
    stop_expiry: StopExpiry = 2.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error where a transform lacks one of its frames."""
        if len(self.transform) == 1:
            yield "transform", "wants two frames: the map's, and another"

    @property
    def flags(self) -> dict[str, str]:
        """Names of the fields of topics with flags, by their topics."""
        fields = ("emergency_stop", "protective_stop", "motors_on")
        return {getattr(self, f): f for f in fields if getattr(self, f)}


@dc.dataclass
class Ros2BaseTopics(RosBase):
    """Commands and topics of a base on ROS 2."""

    # The robot's ROS_DOMAIN_ID; absent: that of the environment, or 0.
    domain: Domain = None
    # Whether commands are geometry_msgs/TwistStamped, as ros2_control's
    # controllers of bases take them since Jazzy; else Twist.
    stamped: bool = False
