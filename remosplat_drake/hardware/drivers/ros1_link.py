"""`Ros1Link`: connects to a base on ROS 1, through rospy.

rospy is not on PyPI. It must be installed from Debian, or as part of a ROS
installation that uses the same Python.
"""

import sys
import time

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.base_driver import (
    Queue,
    StopFlags,
)
from remosplat_drake.hardware.drivers.base_stops import BaseStops
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    read_odometry,
    read_pose,
    read_transforms,
    transform_deviation,
    write_twist,
)
from remosplat_drake.hardware.ros_config import RosBase
from remosplat_drake.hardware.wire.localization import BaseFix

DEBIAN_PACKAGES = "/usr/lib/python3/dist-packages"
"""Folder of Debian's rospy. It is appended to the search path, so that its
modules do not replace installed ones.
"""


class Ros1Link:
    """A `BaseLink` as a ROS 1 node that writes cmd_vel and reads odom."""

    def __init__(self, topics: RosBase):
        """Starts the node; ROS_MASTER_URI in the environment names the master.

        Args:
            topics: The base's topics.

        Raises:
            RemoSplatError: rospy is not installed, or no master answers.
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
        self._queue = Queue[Odometry]()
        self._fixes = Queue[BaseFix]()
        self._flags = StopFlags(topics)
        self._publisher = rospy.Publisher(
            topics.commands, Twist, queue_size=1, tcp_nodelay=True
        )
        self._hear(
            topics.odometry,
            OdometryMessage,
            lambda message: self._queue.put(read_odometry(message)),
        )
        self._hear_localization(topics)
        self._hear_stops(topics)

    def _hear(self, topic: str, kind, callback) -> None:
        self._rospy.Subscriber(
            topic, kind, callback, queue_size=10, tcp_nodelay=True
        )

    def _hear_localization(self, topics: RosBase) -> None:
        if topics.localization:
            from geometry_msgs.msg import PoseWithCovarianceStamped

            self._hear(
                topics.localization,
                PoseWithCovarianceStamped,
                lambda m: self._fixes.put(read_pose(m, topics.base_frame)),
            )
        if topics.transform:
            deviation = transform_deviation(topics)
            map_frame, child = topics.transform
            try:
                from tf2_msgs.msg import TFMessage
            except ImportError as error:
                raise RemoSplatError(
                    "/tf of ROS 1 needs tf2_msgs (on Debian: apt install"
                    f" python3-tf2-msgs): {error}"
                ) from error

            def put(message) -> None:
                for fix in read_transforms(
                    message, (map_frame, child), deviation
                ):
                    self._fixes.put(fix)

            self._hear("/tf", TFMessage, put)

    def _hear_stops(self, topics: RosBase) -> None:
        if not topics.flags:
            return
        from std_msgs.msg import Bool

        for topic, field in topics.flags.items():
            self._hear(
                topic,
                Bool,
                lambda message, field=field: self._flags.put(
                    field, message.data, time.monotonic()
                ),
            )

    def publish(self, velocity: np.ndarray) -> None:
        """Sends a velocity, shape (3,) [m/s, m/s, rad/s], as a Twist."""
        self._publisher.publish(write_twist(self._twist(), velocity))

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        return self._queue.fetch()

    def fetch_fixes(self) -> list[BaseFix]:
        """Returns the localisations since the last call, oldest first."""
        return self._fixes.fetch()

    def stops(self, t: float) -> BaseStops:
        """Returns the stops that the base's topics report at a time t [s]."""
        return self._flags.stops(t)

    def close(self) -> None:
        """Shuts the ROS node down."""
        self._rospy.signal_shutdown("done")
