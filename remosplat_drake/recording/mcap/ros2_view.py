"""`Ros2View`: publishes target, near obstacles and state for RViz.

The node robot_state_publisher of the robot publishes the poses of the links on
/tf. A second source of these poses would conflict with this node. So this class
publishes only the pose of the target on /tf.
"""

import numpy as np

from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.wire.packets import to_utime
from remosplat_drake.recording.mcap.messages import TARGET, WORLD, transforms
from remosplat_drake.recording.mcap.tick_record import TickRecord
from remosplat_drake.robot.robot_model import RobotModel

MARKERS = "/remosplat/markers"
"""Topic of the message visualization_msgs/MarkerArray."""

_SPHERE, _TEXT = 2, 9
"""Numbers of the shapes in the message visualization_msgs/Marker."""

_NEAR = 0.3
"""Clearance below which a link has a marker [m]."""

_GREEN, _RED, _WHITE = (0.2, 0.8, 0.3), (0.9, 0.2, 0.2), (1.0, 1.0, 1.0)


class Ros2View:
    """Publishes markers for RViz, in addition to the robot's own topics."""

    def __init__(self, domain: int | None = None):
        """Joins a ROS 2 domain.

        Args:
            domain: ROS_DOMAIN_ID of the domain; None for the value of the
                environment variable.

        Raises:
            RemoSplatError: CycloneDDS is not installed, or finds no network.
        """
        node = Ros2Node(domain, "--rviz")
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        self._ros = ros
        self._tf = node.writer("/tf", ros.TFMessage)
        self._markers = node.writer(MARKERS, ros.MarkerArray)

    def show(self, record: TickRecord, robot: RobotModel) -> None:
        """Publishes a tick, if the robot has been measured."""
        message = transforms(record, robot)
        if message is None:
            return
        targets = [
            transform
            for transform in message.content["transforms"]
            if transform["child_frame_id"].startswith(TARGET)
        ]
        self._tf.write(self._transforms(record, targets))
        self._markers.write(self._ros.MarkerArray(self._shapes(record, robot)))

    def _header(self, record: TickRecord):
        stamp = self._ros.stamp(to_utime(record.time))
        return self._ros.Header(stamp, WORLD)

    def _transforms(self, record: TickRecord, targets: list[dict]):
        ros, found = self._ros, []
        for target in targets:
            stamped = ros.TransformStamped(
                self._header(record), f"remosplat_{target['child_frame_id']}"
            )
            stamped.transform = ros.Transform(
                ros.Vector3(**target["translation"]),
                ros.Quaternion(**target["rotation"]),
            )
            found.append(stamped)
        return ros.TFMessage(found)

    def _shapes(self, record: TickRecord, robot: RobotModel) -> list:
        """Markers of the targets and near links, and a text of the state."""
        shapes = [
            self._marker(record, "target", i, target.X_WT[:3, 3], 0.04, _GREEN)
            for i, target in record.aim.items
            if target.is_known
        ]
        robot = robot.holding(record.payload)
        p_WSs = robot.spheres_at(record.q).p_WS
        nearest: dict[str, int] = {}
        for row in np.argsort(record.distance)[::-1].tolist():
            nearest[robot.spheres.links[record.sphere[row]]] = row
        for link, row in nearest.items():
            distance = float(record.distance[row])
            if distance < _NEAR:
                p_WS = p_WSs[record.sphere[row]]
                args = (record, "clearance", row, p_WS, 0.03, _RED)
                shapes.append(
                    self._marker(*args, f"{link} {1e3 * distance:.0f} mm")
                )
        standing = ": ".join(filter(None, (record.mode, record.stop_reason)))
        above = p_WSs.max(axis=0)
        text = standing or record.status
        shapes.append(
            self._marker(record, "motion_status", 0, above, 0.08, _WHITE, text)
        )
        return shapes

    def _marker(
        self,
        record: TickRecord,
        ns: str,
        number: int,
        p_W: np.ndarray,
        size: float,
        color: tuple[float, float, float],
        text: str = "",
    ):
        """Makes a marker, a sphere or a text, shown for half a second."""
        ros = self._ros
        marker = ros.Marker(self._header(record), ns, number)
        marker.type = _TEXT if text else _SPHERE
        marker.pose.position = ros.Point(*map(float, p_W))
        marker.scale = ros.Vector3(size, size, size)
        marker.color = ros.ColorRGBA(*color, 1.0)
        marker.lifetime = ros.Duration(0, 500_000_000)
        marker.text = text
        return marker
