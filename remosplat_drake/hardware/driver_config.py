"""Settings of the drivers of a robot's arm, base and hand.

Drivers are plug-ins: in addition to the classes of this module, a scenario may
name a class of another package, such as `arm_driver: !my_arm:MyArm {host:
10.0.0.2}`; see `base.extensions`.
"""

import dataclasses as dc
from typing import TYPE_CHECKING, Annotated, Protocol

from annotated_types import Len

from remosplat_drake.base.ranges import Config
from remosplat_drake.hardware.ros_config import (
    Ros2ArmTopics,
    Ros2BaseTopics,
    Ros2HandTopics,
    RosBase,
    Tell,
)
from remosplat_drake.robot.robot_description import RobotDescription

if TYPE_CHECKING:
    from remosplat_drake.hardware.drivers.arm_driver import ArmLink
    from remosplat_drake.hardware.drivers.base_driver import BaseLink
    from remosplat_drake.hardware.drivers.hand_driver import HandLink


class ArmDriverMaker(Protocol):
    """Protocol of an arm driver's settings; any package may implement it."""

    def connect_arm(
        self, description: RobotDescription, tell: Tell
    ) -> "ArmLink":
        """Connects to the arm, without sending commands.

        Args:
            description: The robot, which names the joints in their order.
            tell: Function that prints a message.
        """
        ...


class BaseDriverMaker(Protocol):
    """Protocol of a base driver's settings; any package may implement it."""

    def connect_base(self, tell: Tell) -> "BaseLink":
        """Connects to the base, without sending commands.

        Args:
            tell: Function that prints a message.
        """
        ...


class HandDriverMaker(Protocol):
    """Protocol of a gripper driver's settings; any package may implement it."""

    def connect_hand(
        self, description: RobotDescription, tell: Tell
    ) -> "HandLink":
        """Connects to the gripper, without sending commands.

        Args:
            description: The robot, which names the finger joints.
            tell: Function that prints a message.
        """
        ...


@dc.dataclass
class UrArm(Config):
    """A Universal Robots arm, through RTDE (extra `ur`)."""

    # Name or address of the controller.
    host: Annotated[str, Len(1, 253)] = "192.168.56.101"

    def connect_arm(
        self, description: RobotDescription, tell: Tell
    ) -> "ArmLink":
        """Connects to the controller; see `UrArmLink`."""
        from remosplat_drake.hardware.drivers.ur_arm import UrArmLink

        return UrArmLink(self.host, description)


@dc.dataclass
class Ros2Arm(Ros2ArmTopics):
    """An arm with ros2_control, over DDS without ROS (extra `ros2`)."""

    def connect_arm(
        self, description: RobotDescription, tell: Tell
    ) -> "ArmLink":
        """Joins the ROS 2 domain; see `Ros2ArmLink`."""
        from remosplat_drake.hardware.drivers.ros2_arm import Ros2ArmLink

        return Ros2ArmLink(self, description, tell)


@dc.dataclass
class Ros1Base(RosBase):
    """A base on ROS 1, through rospy."""

    def connect_base(self, tell: Tell) -> "BaseLink":
        """Starts a ROS 1 node; see `Ros1Link`."""
        from remosplat_drake.hardware.drivers.ros1_link import Ros1Link

        return Ros1Link(self)


@dc.dataclass
class Ros2Base(Ros2BaseTopics):
    """A base on ROS 2, over DDS without ROS (extra `ros2`)."""

    def connect_base(self, tell: Tell) -> "BaseLink":
        """Joins the ROS 2 domain; see `Ros2Link`."""
        from remosplat_drake.hardware.drivers.ros2_link import Ros2Link

        return Ros2Link(self)


@dc.dataclass
class Ros2Hand(Ros2HandTopics):
    """A gripper on ROS 2, over DDS without ROS (extra `ros2`)."""

    def connect_hand(
        self, description: RobotDescription, tell: Tell
    ) -> "HandLink":
        """Joins the ROS 2 domain; see `Ros2HandLink`."""
        from remosplat_drake.hardware.drivers.ros2_hand import Ros2HandLink

        return Ros2HandLink(self, description, tell)
