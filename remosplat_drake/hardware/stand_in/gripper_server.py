"""`GripperServer`: the action of ros2_control's GripperActionController."""

import time
from typing import TYPE_CHECKING

from remosplat_drake.hardware.drivers.ros2_gripper_action import (
    ABORTED,
    EXECUTING,
    SUCCEEDED,
)
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node, taken

if TYPE_CHECKING:
    from remosplat_drake.hardware.drivers.ros2_messages import GripperCommand

_TOLERANCE = 0.01
"""The goal counts as reached within this distance, in the action's unit."""

_STILL = 1e-3
"""Speed below which the fingers count as stalled, in positions per second."""

_STALLED = 1.0
"""The goal is aborted when the fingers have been stalled for this time [s]."""


class GripperServer:
    """Accepts every goal of an action, and publishes the goals' states.

    A new goal replaces the previous one. A request contains its client's
    identity, as in ROS 2's layer for CycloneDDS.
    """

    def __init__(self, node: Ros2Node, name: str):
        """Opens the action's topics.

        Args:
            node: The participant of the robot's domain.
            name: Name of the action.

        Raises:
            RemoSplatError: A topic cannot be opened.
        """
        from remosplat_drake.hardware.drivers import ros2_action_messages as ros

        self._ros = ros
        self._requests = node.request_reader(
            f"{name}/_action/send_goal", ros.GoalRequest
        )
        self._states = node.writer(
            f"{name}/_action/status", ros.GoalStatusArray, latched=True
        )
        self._goal: ros.GoalRequest | None = None
        self._moved = 0.0

    def commands(self) -> "list[GripperCommand]":
        """Accepts the goals that have arrived, and returns their commands."""
        requests = taken(self._requests)
        for request in requests:
            if self._goal is not None:
                self._publish(ABORTED)
            self._goal, self._moved = request, time.monotonic()
            self._publish(EXECUTING)
        return [request.goal.command for request in requests]

    def tell(self, position: float, rate: float) -> None:
        """Ends the goal if the fingers have reached it, or have stalled.

        Args:
            position: Position of the fingers, in the action's unit.
            rate: Its derivative.
        """
        if self._goal is None:
            return
        now = time.monotonic()
        if abs(rate) > _STILL:
            self._moved = now
        goal = self._goal.goal.command.position
        if abs(position - goal) < _TOLERANCE:
            self._end(SUCCEEDED)
        elif now - self._moved > _STALLED:
            self._end(ABORTED)

    def _end(self, state: int) -> None:
        self._publish(state)
        self._goal = None

    def _publish(self, state: int) -> None:
        ros = self._ros
        assert self._goal is not None
        info = ros.GoalInfo(self._goal.goal_id)
        self._states.write(ros.GoalStatusArray([ros.GoalStatus(info, state)]))
