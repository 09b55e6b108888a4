"""Connects to a Franka arm by libfranka, and controls it."""

import dataclasses as dc
import importlib
from collections.abc import Callable
from typing import Any

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.franka_host import one_line

LIBFRANKA = "panda_py.libfranka"
"""Module with libfranka's interface to a real arm."""

IMPEDANCE = [3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0]
"""Stiffness of the arm's own joint impedance control [N m/rad], as in
drake-franka-driver and libfranka's examples.
"""

NO_LOW_PASS = 1000.0
"""With this cutoff frequency, libfranka's low-pass filter is off [Hz]."""


@dc.dataclass(frozen=True)
class CollisionLimits:
    """Collision thresholds, beyond which the arm stops by a reflex.

    The defaults are those of libfranka's `generate_joint_velocity_motion`.
    Settings in Franka's Desk have no effect, since the driver sets these
    thresholds.

    Attributes:
        torque: Thresholds of external torques on the joints, seven [N m].
        force: Thresholds of external force and torque on the hand, six [N, N
            m].
    """

    torque: tuple[float, ...] = (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
    force: tuple[float, ...] = (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)


class FrankaArm:
    """A connection to an arm, which reads states and commands joint rates."""

    def __init__(self, library: str, host: str):
        """Connects to the arm, without changing its settings.

        Args:
            library: Name of the module: `LIBFRANKA`, or another module with the
                same interface.
            host: Name or address of the arm's controller.

        Raises:
            RemoSplatError: The library is not installed, or cannot connect.
        """
        try:
            self.library: Any = importlib.import_module(library)
        except ImportError as error:
            raise MissingExtraError("the Panda driver", "panda") from error
        self._host = host
        try:
            self._robot = self.library.Robot(
                host, self.library.RealtimeConfig.kIgnore
            )
        except RuntimeError as error:
            raise self._error(error) from error

    def take(self, limits: CollisionLimits) -> None:
        """Sets collision thresholds and impedance; must precede `move`.

        Args:
            limits: Collision thresholds of the arm.

        Raises:
            RemoSplatError: The arm is not ready to move, or rejects the
                settings.
        """
        mode = self.state().robot_mode.name
        if mode != "kIdle":
            raise RemoSplatError(
                f"{self._host}: the arm is not idle but {mode[1:]}: release its"
                " stops, unlock its joints and recover from errors in Desk"
            )
        torque, force = list(limits.torque), list(limits.force)
        try:
            self._robot.set_collision_behavior(torque, torque, force, force)
            self._robot.set_joint_impedance(IMPEDANCE)
        except RuntimeError as error:
            raise self._error(error) from error

    def state(self) -> Any:
        """Waits for the next `RobotState`; must not be called during `move`.

        Raises:
            RemoSplatError: The connection is lost.
        """
        try:
            return self._robot.read_once()
        except RuntimeError as error:
            raise self._error(error) from error

    def move(self, callback: Callable[[Any, Any], Any]) -> str:
        """Controls the joint rates by a callback until the motion ends.

        Libfranka's own rate limiter and low-pass filter are off, since the
        callback limits and smooths the rates itself, and reports violations.

        Returns:
            The reason why the robot has aborted the motion; empty if it has
            not.
        """
        try:
            self._robot.control_joint_velocity(
                callback,
                self.library.ControllerMode.kJointImpedance,
                False,
                NO_LOW_PASS,
            )
        except RuntimeError as error:
            return one_line(error)
        return ""

    def _error(self, error: RuntimeError) -> RemoSplatError:
        return RemoSplatError(f"{self._host}: {one_line(error)}")
