"""`Ros2Description`: compares the URDF on /robot_description with our model."""

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.urdf_agreement import urdf_problem


class Ros2Description:
    """The robot's URDF, which must agree with our model before motion."""

    def __init__(
        self, node: Ros2Node, topic: str, description: RobotDescription
    ):
        """Opens the topic.

        Args:
            node: The participant of the robot's domain.
            topic: Topic of std_msgs/String, latched.
            description: Our description of the robot.
        """
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._topic, self._description = topic, description
        self._reader = node.reader(topic, ros.String, latched=True)
        self._text: str | None = None
        self._problem = "nothing came yet"

    def problem(self) -> str:
        """Returns why the robot must not move; empty if it may move."""
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
