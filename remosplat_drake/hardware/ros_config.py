"""Settings of the ROS 1 or ROS 2 topics of arms, bases and grippers."""

import dataclasses as dc
import re
from collections.abc import Callable, Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf

Tell = Callable[[str], None]
"""Type of functions that print a message."""

STRING, INT32, BOOL = "String", "Int32", "Bool"
MODE_TYPES = (STRING, INT32, BOOL)
"""Types of std_msgs messages that may contain an arm's mode."""

VELOCITIES, TRAJECTORY = "velocities", "trajectory"
COMMANDS = (VELOCITIES, TRAJECTORY)
"""Types of commands to controllers of ros2_control: Float64MultiArray, or
JointTrajectory.
"""

EMERGENCY_STOP, MODE = "emergency_stop", "mode"

Topic = Annotated[str, Len(1, 256)]
"""Name of a ROS topic."""

StopExpiry = Annotated[float, Interval(gt=0, le=3600)] | None
"""After this time without messages, the value of a topic is unknown [s]; None
for topics that publish only changes.
"""

Domain = Annotated[int, Interval(ge=0, le=232)] | None
"""Type of a ROS_DOMAIN_ID; None takes the value of the environment variable, or
0.
"""


@dc.dataclass
class Ros2Controller(Config):
    """A controller of ros2_control that moves joints of the arm."""

    # Topic of its commands.
    topic: Topic = "/velocity_controller/commands"
    # Type of the controller's commands: `velocities` for the Float64MultiArray
    # of a JointGroupVelocityController, `trajectory` for the JointTrajectory of
    # a JointTrajectoryController.
    takes: Annotated[str, OneOf(COMMANDS)] = VELOCITIES
    # Joints of the controller, in the controller's order. If empty, these are
    # all joints of the arm, in the order of the description.
    joints: list[str] = dc.field(default_factory=list)


@dc.dataclass
class Ros2ArmTopics(Config):
    """Commands and topics of an arm with ros2_control."""

    # The robot's ROS_DOMAIN_ID. If absent, it is the value of the environment
    # variable, or 0.
    domain: Domain = None
    # The controllers; each joint of the arm must belong to one of them.
    controllers: Annotated[list[Ros2Controller], Len(1, 16)] = dc.field(
        default_factory=lambda: [Ros2Controller()]
    )
    # Topic of the sensor_msgs/JointState measurements.
    states: Topic = "/joint_states"
    # Topic of the robot's URDF, a std_msgs/String such as /robot_description.
    # The arm is stopped unless joints, limits and axes agree with the robot's
    # description. If empty, they are not compared.
    description: str = ""
    # Cutoff frequency of the low-pass filter for differentiated positions [Hz],
    # for joint states without velocities. If absent, such joint states are
    # rejected. Differentiated velocities lag by 1 / (2 pi cutoff) and half a
    # period of the joint states.
    differentiate: Annotated[float, Interval(ge=1, le=200)] | None = None
    # Topic of a std_msgs/Bool that states whether an emergency stop is latched.
    # If empty, this is not known.
    emergency_stop: str = ""
    # Topic of the arm's mode. If empty, the mode is unknown.
    mode: str = ""
    # Type of the messages of the topic `mode`, from std_msgs: `String`, `Int32`
    # or `Bool`.
    mode_type: Annotated[str, OneOf(MODE_TYPES)] = STRING
    # Values of the topic `mode` with which the arm follows commands, as text:
    # `"true"` for a Bool, `"7"` for an Int32.
    running_modes: Annotated[list[str], Len(0, 32)] = dc.field(
        default_factory=list
    )
    # Time without messages on the topics `emergency_stop` and `mode` after
    # which the arm counts as stopped [s]; null for topics that publish only
    # changes.
    stop_expiry: StopExpiry = 2.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for modes that contradict each other."""
        if bool(self.running_modes) != bool(self.mode):
            yield "running_modes", "set both this field and `mode`, or neither"
        for i, mode in enumerate(self.running_modes):
            field = f"running_modes[{i}]"
            if self.mode_type == BOOL and mode not in ("true", "false"):
                yield field, f"{mode!r}: a {BOOL} is true or false"
            whole = re.fullmatch(r"0|-?[1-9]\d*", mode)
            if self.mode_type == INT32 and not whole:
                yield field, f"{mode!r}: an {INT32} is a whole number"

    @property
    def stops(self) -> dict[str, str]:
        """The topics that report whether the arm may move, keyed by field."""
        topics = {EMERGENCY_STOP: self.emergency_stop, MODE: self.mode}
        return {field: topic for field, topic in topics.items() if topic}


@dc.dataclass
class Ros2HandTopics(Config):
    """Commands and topics of a gripper on ROS 2."""

    # The robot's ROS_DOMAIN_ID. If absent, it is the value of the environment
    # variable, or 0.
    domain: Domain = None
    # Name of the control_msgs/GripperCommand action, such as
    # /gripper_controller/gripper_cmd of a GripperActionController; empty:
    # commands are sent to the topic `commands`.
    action: str = ""
    # Topic of the control_msgs/GripperCommand commands, if there is no action.
    commands: Topic = "/gripper_controller/command"
    # Topic of the sensor_msgs/JointState measurements.
    states: Topic = "/joint_states"
    # Finger joints whose positions add up to the opening. If empty, they are
    # those of the robot's description.
    joints: list[str] = dc.field(default_factory=list)
    # Ratio of the position in a command to the opening: 1 if the position is
    # the opening, 0.5 if it is the travel of one of two fingers.
    position_share: Annotated[float, Interval(gt=0, le=100)] = 1.0


@dc.dataclass
class RosBase(Config):
    """Topics of a base, which are the same on ROS 1 and ROS 2."""

    # Topic of the velocity commands.
    commands: Topic = "/cmd_vel"
    # Topic of the nav_msgs/Odometry measurements.
    odometry: Topic = "/odom"
    # Topic of the base's pose in the map, a
    # geometry_msgs/PoseWithCovarianceStamped such as /amcl_pose. If empty,
    # there is no such topic.
    localization: str = ""
    # Name of the frame whose pose the topic `localization` contains.
    base_frame: str = "base_link"
    # Names of two frames: the map's frame, and the frame of the odometry or of
    # the base, whose pose in the map is read from /tf. If empty, /tf is not
    # used.
    transform: Annotated[list[str], Len(0, 2)] = dc.field(default_factory=list)
    # Standard deviation of the position by /tf [m].
    transform_shift: Annotated[float, Interval(gt=0, le=1)] = 0.05
    # Standard deviation of the heading by /tf [deg].
    transform_turn_deg: Annotated[float, Interval(gt=0, le=45)] = 2.0
    # Topic of a std_msgs/Bool that states whether an emergency stop is latched.
    # If empty, this is not known.
    emergency_stop: str = ""
    # Topic of a std_msgs/Bool that states whether the safety scanner stops the
    # base. If empty, this is not known.
    protective_stop: str = ""
    # Topic of a std_msgs/Bool that states whether the motors are on. If empty,
    # this is not known.
    motors_on: str = ""
    # Time without messages on the topics `emergency_stop`, `protective_stop`
    # and `motors_on` after which the base counts as stopped [s]; null for
    # topics that publish only changes.
    stop_expiry: StopExpiry = 2.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error if `transform` does not name two frames."""
        if len(self.transform) == 1:
            yield "transform", "expected two frames: the map's, and another"

    @property
    def flags(self) -> dict[str, str]:
        """Maps the topics that report flags to their fields' names."""
        fields = ("emergency_stop", "protective_stop", "motors_on")
        return {getattr(self, f): f for f in fields if getattr(self, f)}


@dc.dataclass
class Ros2BaseTopics(RosBase):
    """Commands and topics of a base on ROS 2."""

    # The robot's ROS_DOMAIN_ID. If absent, it is the value of the environment
    # variable, or 0.
    domain: Domain = None
    # Whether commands are geometry_msgs/TwistStamped, as for ros2_control's
    # base controllers since Jazzy; otherwise they are Twist.
    stamped: bool = False
