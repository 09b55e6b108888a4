"""`GripperAction`: a client of ROS 2's action control_msgs/GripperCommand.

An action consists of three services and two topics. A goal is a request of the
service `send_goal`, and the topic `status` contains the state of all goals. The
client needs no replies, since it chooses the identifier of its goal.

The only difference between implementations of DDS is how a request names its
client: Fast DDS and Connext use the sender of the packet, while ROS 2's layer
for CycloneDDS adds 16 bytes. So the client reads the server's vendor from its
DDS identifier.
"""

import itertools
import time
import uuid

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken

CYCLONE = b"\x01\x10"
"""Vendor of CycloneDDS: the first two bytes of its participants' GUIDs."""

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(1, 7)
"""States of a goal in action_msgs/GoalStatus."""

ENDED = (SUCCEEDED, CANCELED, ABORTED)
"""States in which a goal has ended. A gripper that holds something aborts its
goal, unless its controller has `allow_stalling`."""

_PATIENCE = 5.0
"""Longest wait for the server, and for its answer to a goal [s]."""

_STEP = 0.01


class GripperAction:
    """Sends goals to a gripper's action server, and reads their states."""

    def __init__(self, node: Ros2Node, name: str):
        """Opens the action's topics; sends nothing.

        Args:
            node: The participant of the robot's domain.
            name: Name of the action, such as /gripper_controller/gripper_cmd.

        Raises:
            RemoSplatError: A topic cannot be opened.
        """
        from remosplat_drake.hardware.drivers import ros2_action_messages as ros

        self._ros, self._node, self._name = ros, node, name
        self._service = f"{name}/_action/send_goal"
        self._requests = node.request_writer(self._service, ros.GoalRequest)
        self._states = node.reader(
            f"{name}/_action/status", ros.GoalStatusArray, latched=True
        )
        self._client, self._count = uuid.uuid4().bytes[:8], itertools.count(1)
        self._goal = b""
        self._state = 0

    def send(self, position: float, force: float) -> None:
        """Sends a goal, and returns when the server has accepted it.

        Args:
            position: Commanded position, in the controller's unit.
            force: Bound on the force [N].

        Raises:
            RemoSplatError: There is no server, or it did not accept the goal.
        """
        vendor, ros = self._server(), self._ros
        self._goal, self._state = uuid.uuid4().bytes, 0
        request = ros.GoalRequest.of(self._goal, position, force)
        if vendor == CYCLONE:
            request.client = ros.client_header(self._client, next(self._count))
        self._requests.write(request)
        if not self._wait(lambda: self.state() > 0):
            raise RemoSplatError(
                f"{self._name}: the action server did not accept the goal"
                f" within {_PATIENCE:g} s"
            )

    def state(self) -> int:
        """Returns the state of the latest goal; 0 before it was accepted."""
        for message in taken(self._states):
            for status in message.status_list:
                if bytes(status.goal_info.goal_id.uuid) == self._goal:
                    self._state = status.status
        return self._state

    def _server(self) -> bytes:
        """Waits for one action server, and returns its vendor."""
        found: list[bytes] = []

        def is_there() -> bool:
            found[:] = self._node.servers(self._service)
            return bool(found and self._requests.get_matched_subscriptions())

        if not self._wait(is_there):
            raise RemoSplatError(
                f"{self._name}: no action server of the type"
                f" control_msgs/GripperCommand within {_PATIENCE:g} s"
            )
        if len(found) > 1:
            raise RemoSplatError(
                f"{self._name}: has {len(found)} action servers, not one"
            )
        return found[0]

    def _wait(self, done) -> bool:
        end = time.monotonic() + _PATIENCE
        while not done():
            if time.monotonic() > end:
                return False
            time.sleep(_STEP)
        return True
