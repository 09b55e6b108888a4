"""`Ros2Description`: compares a robot's URDF on ROS 2 with its description."""

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.urdf_agreement import urdf_problem


class Ros2Description:
    """The URDF on a topic, which must agree with the robot's description."""

    def __init__(
        self, node: Ros2Node, topic: str, description: RobotDescription
    ):
        """Opens the topic.

        Args:
            node: The participant of the robot's domain.
            topic: Topic of std_msgs/String, latched.
            description: The description that the controller uses.
        """
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._topic, self._description = topic, description
        self._reader = node.reader(topic, ros.String, latched=True)
        self._text: str | None = None
        self._problem = "nothing came yet"

    def problem(self) -> str:
        """Returns the reason why the robot must not move, or ""."""
        for sample in taken(self._reader):
            self._take(sample.data)
        return f"{self._topic}: {self._problem}" if self._problem else ""

    def _take(self, text: str) -> None:
        if self._text is None:
            self._text = text
            self._problem = urdf_problem(text, self._description)
        elif text != self._text:
            # The comparison takes too long for an arm in motion.
            self._problem = "has changed: restart the driver"
