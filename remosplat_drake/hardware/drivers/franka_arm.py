"""Opens a Franka arm as libfranka does it, and takes control of it."""

import dataclasses as dc
import importlib
from collections.abc import Callable
from typing import Any

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.franka_host import one_line

LIBFRANKA = "panda_py.libfranka"
"""The module that drives a real arm."""

IMPEDANCE = [3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0]
"""Stiffness of the arm's own joint impedance control [N m/rad], as
drake-franka-driver and libfranka's examples set it."""

NO_LOW_PASS = 1000.0
"""Cutoff frequency from which libfranka filters nothing [Hz]."""


@dc.dataclass(frozen=True)
class CollisionLimits:
    """What the arm takes for a collision, upon which it stops by reflex.

    The defaults are those of libfranka's `generate_joint_velocity_motion`.
    What is set in Desk does not hold: whoever drives the arm sets its own.

    Attributes:
        torque: External torques on the joints, seven [N m].
        force: External force and torque on the hand, six [N, N m].
    """

    torque: tuple[float, ...] = (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
    force: tuple[float, ...] = (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)


class FrankaArm:
    """An arm that is ready for joint velocity control."""

    def __init__(self, library: str, host: str, limits: CollisionLimits):
        """Connects and sets collision limits and impedance.

        Args:
            library: Name of the module to use: `LIBFRANKA`, or one with the
                same interface.
            host: Name or address of the arm's controller.
            limits: What the arm shall take for a collision.

        Raises:
            RemoSplatError: The library is absent, it cannot connect, or the
                arm is not ready to move.
        """
        try:
            self.library: Any = importlib.import_module(library)
        except ImportError as error:
            raise MissingExtraError("the Panda driver", "panda") from error
        try:
            self._robot = self.library.Robot(
                host, self.library.RealtimeConfig.kIgnore
            )
            _check_idle(host, self._robot.read_once().robot_mode)
            torque, force = list(limits.torque), list(limits.force)
            self._robot.set_collision_behavior(torque, torque, force, force)
            self._robot.set_joint_impedance(IMPEDANCE)
        except RuntimeError as error:
            raise RemoSplatError(f"{host}: {one_line(error)}") from error

    def state(self) -> Any:
        """Returns a `RobotState` of now, while nothing is controlled."""
        return self._robot.read_once()

    def move(self, callback: Callable[[Any, Any], Any]) -> str:
        """Lets a callback control the joint rates until the motion ends.

        Libfranka's own limiter and low pass are off: what they would do to a
        command, the callback does better, and says so.

        Returns:
            What the robot has aborted the motion for; empty if it has not.
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


def _check_idle(host: str, mode: Any) -> None:
    if mode.name != "kIdle":
        raise RemoSplatError(
            f"{host}: the arm is not idle but {mode.name[1:]}: release its"
            " stops, unlock its joints and recover from errors in Desk"
        )
