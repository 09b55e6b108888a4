"""`Ros1Link`: ROS 1 through rospy, as the lab of the paper runs it.

rospy is no package of PyPI: it comes from Debian, or from a ROS installation
whose Python is this one.
"""

import sys

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.ros_base import OdometryQueue
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    read_odometry,
    write_twist,
)

DEBIAN_PACKAGES = "/usr/lib/python3/dist-packages"
"""Where Debian keeps rospy; appended, so that it shadows nothing of ours."""


class Ros1Link:
    """A `RosLink` by rospy: a node that writes cmd_vel and reads odom."""

    def __init__(self, command_topic: str, odometry_topic: str):
        """Joins ROS; the environment says where its master is.

        Args:
            command_topic: Topic of the geometry_msgs/Twist commands.
            odometry_topic: Topic of the nav_msgs/Odometry measurements.

        Raises:
            RemoSplatError: There is no rospy, or no master answers.
        """
        if DEBIAN_PACKAGES not in sys.path:
            sys.path.append(DEBIAN_PACKAGES)
        try:
            import rosgraph
            import rospy
            from geometry_msgs.msg import Twist
            from nav_msgs.msg import Odometry as OdometryMessage
        except ImportError as error:
            raise RemoSplatError(
                f"ROS 1 needs rospy (on Debian: apt install python3-rospy"
                f" python3-geometry-msgs python3-nav-msgs): {error}"
            ) from error
        if not rosgraph.is_master_online():
            raise RemoSplatError(
                f"no ROS master at {rosgraph.get_master_uri()}; set"
                " ROS_MASTER_URI to the robot's"
            )
        rospy.init_node("remosplat_base", anonymous=True, disable_signals=True)
        self._rospy = rospy
        self._twist = Twist
        self._queue = OdometryQueue()
        self._publisher = rospy.Publisher(
            command_topic, Twist, queue_size=1, tcp_nodelay=True
        )
        rospy.Subscriber(
            odometry_topic,
            OdometryMessage,
            lambda message: self._queue.put(read_odometry(message)),
            queue_size=10,
            tcp_nodelay=True,
        )

    def publish(self, forward: float, yaw_rate: float) -> None:
        """Sends a Twist with these speeds [m/s, rad/s]."""
        self._publisher.publish(write_twist(self._twist(), forward, yaw_rate))

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        return self._queue.fetch()

    def close(self) -> None:
        """Shuts the ROS node down."""
        self._rospy.signal_shutdown("done")
