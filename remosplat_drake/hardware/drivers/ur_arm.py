"""`UrArmLink`: connects to a Universal Robots arm, by ur_rtde's `speedJ`."""

import numpy as np
from drake import lcmt_panda_status

from remosplat_drake.base.errors import (
    FieldError,
    MissingExtraError,
    RemoSplatError,
)
from remosplat_drake.hardware.drivers.arm_driver import ArmReport
from remosplat_drake.robot.robot_description import RobotDescription

FREQUENCY = 500.0
"""Rate at which an e-Series controller sends its state [Hz]."""

WATCHDOG = 10.0
"""Least rate of commands [Hz]. At a lower rate, the controller's program ends,
and the arm brakes."""

DECELERATION = 10.0
"""Deceleration of the stop in `close` [rad/s^2]."""

_JOINTS = 6

_PAUSED = "its program has ended"


class UrArmLink:
    """Commands and states of one arm; an `ArmLink`.

    If this process ends, the arm stops, because the controller's watchdog ends
    a program that receives no commands. The watchdog is off until the first
    command, so that the arm may wait at rest for its first controller.
    """

    def __init__(self, host: str, description: RobotDescription):
        """Uploads ur_rtde's program, and waits until it runs.

        Args:
            host: Name or address of the controller.
            description: The robot, with the delays of its joints.

        Raises:
            RemoSplatError: The robot does not have six joints, ur_rtde is not
                installed, or the controller does not answer or does not run the
                program, for example if remote control is off.
        """
        n = len(description.arm.joints)
        if n != _JOINTS:
            raise FieldError(
                description.source,
                "arm.joints",
                f"{description.name} has {n} joints, a Universal Robots arm"
                f" has {_JOINTS}",
            )
        try:
            from rtde_control import RTDEControlInterface
            from rtde_receive import RTDEReceiveInterface
        except ImportError as error:
            raise MissingExtraError("a Universal Robots arm", "ur") from error
        # The controller applies this acceleration to the joint with the largest
        # change of speed.
        self._acceleration = max(description.acceleration_limits)
        self._told = -1.0
        self._is_watched = False
        try:
            self._receive = RTDEReceiveInterface(host, FREQUENCY)
            self._control = RTDEControlInterface(host, FREQUENCY)
        except (RuntimeError, OSError) as error:
            text = " ".join(str(error).split())
            raise RemoSplatError(f"{host}: {text}") from error

    def command(self, velocity: np.ndarray) -> None:
        """Sends joint rates to the controller, shape (6,) [rad/s]."""
        if not self._is_watched:
            self._is_watched = True
            self._control.setWatchdog(WATCHDOG)
        if self._control.isProgramRunning():
            self._control.speedJ(velocity.tolist(), self._acceleration, 0.0)

    def fetch(self) -> ArmReport | None:
        """Returns the latest report; None if there is no new one."""
        receive = self._receive
        time = receive.getTimestamp()
        if time == self._told:
            return None
        self._told = time
        mode, problem = self._mode()
        return ArmReport(
            np.array(receive.getActualQ()),
            np.array(receive.getActualQd()),
            time,
            mode,
            problem,
        )

    def _mode(self) -> tuple[int, str]:
        """Returns the mode, as in libfranka, and the reason of a stop."""
        if self._receive.isEmergencyStopped():
            return lcmt_panda_status.kUserStopped, "emergency stop"
        if self._receive.isProtectiveStopped():
            return lcmt_panda_status.kReflex, "protective stop"
        if not self._control.isProgramRunning():
            return lcmt_panda_status.kOther, _PAUSED
        return lcmt_panda_status.kMove, ""

    def close(self) -> None:
        """Brakes the arm, and ends the program."""
        try:
            if self._control.isProgramRunning():
                self._control.speedStop(DECELERATION)
                self._control.stopScript()
        finally:
            self._control.disconnect()
            self._receive.disconnect()
