"""Sends joint rates to controllers of ros2_control."""

import math
import time
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.ros_config import TRAJECTORY, Ros2Controller
from remosplat_drake.hardware.wire.channels import COMMAND_EXPIRY
from remosplat_drake.robot.robot_description import RobotDescription

HORIZON = COMMAND_EXPIRY
"""A trajectory continues at the commanded rates for this time, and then brakes
[s]. If no newer trajectory comes, the arm comes to rest.
"""

_LEAD = 0.2
"""A trajectory may be ahead of the measured joints by at most the distance that
they cover in this time at their greatest rates [s].
"""


class Controllers:
    """The controllers of an arm; each joint belongs to one of them."""

    def __init__(
        self,
        node: Ros2Node,
        controllers: Sequence[Ros2Controller],
        description: RobotDescription,
    ):
        """Opens the topics of the controllers.

        Args:
            node: The participant of the robot's domain.
            controllers: The controllers.
            description: The robot.

        Raises:
            RemoSplatError: A joint is unknown, or has no controller or several.
        """
        self._writers = [
            _writer(node, controller, rows, description)
            for controller, rows in _rows(controllers, description)
        ]

    def command(self, rates: np.ndarray, q: np.ndarray | None) -> None:
        """Sends joint rates to all controllers.

        Args:
            rates: Joint rates of the whole arm, shape (n,) [rad/s].
            q: Joint positions of the arm, shape (n,) [rad]; None if they are
                unknown.
        """
        for write in self._writers:
            write(rates, q)


Write = Callable[[np.ndarray, np.ndarray | None], None]
"""Type of functions that send the rates of the whole arm [rad/s]. They also
receive the arm's positions [rad], or None if these are unknown.
"""


def _rows(
    controllers: Sequence[Ros2Controller], description: RobotDescription
) -> list[tuple[Ros2Controller, list[int]]]:
    """Finds the joints of the arm that each controller moves."""
    arm, found = list(description.arm.joints), []
    for controller in controllers:
        for joint in controller.joints:
            if joint not in arm:
                problem = unknown_name("joint", joint, arm)
                raise RemoSplatError(f"{controller.topic}: {problem}")
        names = controller.joints or arm
        found.append((controller, [arm.index(name) for name in names]))
    for i, joint in enumerate(arm):
        count = sum(rows.count(i) for _, rows in found)
        if count != 1:
            has = "no controller" if not count else f"{count} controllers"
            raise RemoSplatError(
                f"controllers: {joint} of {description.name} has {has}; list"
                " this joint under `joints` of one controller"
            )
    return found


def _writer(
    node: Ros2Node,
    controller: Ros2Controller,
    rows: list[int],
    description: RobotDescription,
) -> Write:
    from remosplat_drake.hardware.drivers import ros2_messages as ros

    if controller.takes == TRAJECTORY:
        writer = node.writer(controller.topic, ros.JointTrajectory)
        stretch = TrajectoryStretch(description, rows)
        return lambda rates, q: (
            None if q is None else writer.write(stretch.message(rates, q))
        )
    writer = node.writer(controller.topic, ros.Float64MultiArray)
    return lambda rates, q: writer.write(
        ros.Float64MultiArray(data=rates[rows].tolist())
    )


class TrajectoryStretch:
    """Converts joint rates to short trajectories that end at rest."""

    def __init__(
        self,
        description: RobotDescription,
        rows: Sequence[int],
        clock: Callable[[], float] = time.monotonic,
    ):
        """Starts at rest.

        Args:
            description: The robot.
            rows: Indices of the trajectory's joints among the arm's joints.
            clock: A monotonic clock [s].
        """
        n, clock_now = description.n_base, clock()
        rows = list(rows)
        self._joints = [description.arm.joints[i] for i in rows]
        self._rows, self._clock, self._then = rows, clock, clock_now
        limits = np.array(description.velocity_limits)[n:]
        self._lead = _LEAD * limits[rows]
        self._braking = np.array(description.acceleration_limits)[n:][rows]
        self._q: np.ndarray | None = None
        self._rates = np.zeros(len(rows))

    def message(self, rates: np.ndarray, q: np.ndarray):
        """Returns a trajectory that starts now at the commanded joint rates.

        It starts at the end of the previous trajectories, not at the measured
        positions, since measurements are late.

        Args:
            rates: Joint rates of the whole arm, shape (n,) [rad/s].
            q: Measured joint positions of the arm, shape (n,) [rad].

        Returns:
            A trajectory_msgs/JointTrajectory.
        """
        from remosplat_drake.hardware.drivers import ros2_messages as ros

        rates, q, now = rates[self._rows], q[self._rows], self._clock()
        led = q if self._q is None else self._q
        led = led + min(now - self._then, HORIZON) * self._rates
        self._q = np.clip(led, q - self._lead, q + self._lead)
        self._rates, self._then = rates, now
        brakes = max(float((np.abs(rates) / self._braking).max()), 0.01)
        ahead = self._q + HORIZON * rates
        points = [
            ros.JointTrajectoryPoint(
                positions=ahead.tolist(),
                velocities=rates.tolist(),
                time_from_start=_duration(HORIZON),
            ),
            ros.JointTrajectoryPoint(
                positions=(ahead + 0.5 * brakes * rates).tolist(),
                velocities=[0.0] * len(rates),
                time_from_start=_duration(HORIZON + brakes),
            ),
        ]
        return ros.JointTrajectory(joint_names=self._joints, points=points)


def _duration(seconds: float):
    from remosplat_drake.hardware.drivers import ros2_messages as ros

    whole = math.floor(seconds)
    return ros.Duration(whole, round(1e9 * (seconds - whole)))
