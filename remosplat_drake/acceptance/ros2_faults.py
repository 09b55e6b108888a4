"""`Ros2Faults`: requests faults of a stand-in on ROS 2."""

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.stand_in.ros2_robot import FAULTS_TOPIC


class Ros2Faults:
    """Sends requests for faults to `remosplat hardware-sim --ros2`.

    Attributes:
        domain: The stand-in's ROS_DOMAIN_ID.
    """

    def __init__(self, domain: int):
        """Joins the domain.

        Args:
            domain: The stand-in's ROS_DOMAIN_ID.

        Raises:
            RemoSplatError: CycloneDDS is not installed.
        """
        node = Ros2Node(domain, "a fault of a robot on ROS 2")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self.domain, self._ros = domain, ros
        self._writer = node.writer(FAULTS_TOPIC, ros.String)

    def inject(self, fault: str, value: float = 0.0) -> None:
        """Begins a fault now.

        Args:
            fault: A key of `faults.FAULTS`.
            value: Size of the fault; 0 stands for its default.
        """
        text = f"{fault}={value}" if value else fault
        self._writer.write(self._ros.String(text))
