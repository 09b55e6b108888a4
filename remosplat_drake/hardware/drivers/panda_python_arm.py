"""`PandaPythonArm`: a real Panda through panda-python.

Its C++ thread holds the arm to the integral of the commanded rates, at 1 kHz,
by joint impedance. Python only changes the rates: a late Python costs no
packet, but an arm whose Python has stalled goes on at its last rates. The
station's supervisor sees that by the age of the statuses; drake-franka-driver
has no such gap, and is the better choice where it can be built.
"""

from typing import Any

import numpy as np

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.franka_host import (
    check_reachable,
    one_line,
)


class PandaPythonArm:
    """A `FrankaArm` under joint velocity control, until `close`."""

    def __init__(self, host: str):
        """Connects and takes control; the arm stands still.

        Args:
            host: Name or address of the arm's controller.

        Raises:
            RemoSplatError: panda-python is absent, nobody answers, or the
                arm is not ready to move.
        """
        try:
            import panda_py
            from panda_py import controllers, libfranka
        except ImportError as error:
            raise MissingExtraError("the Panda driver", "panda") from error
        check_reachable(host)
        try:
            self._panda = panda_py.Panda(host)
            state = self._panda.get_robot().read_once()
            if state.robot_mode != libfranka.RobotMode.kIdle:
                raise RemoSplatError(
                    f"{host}: the arm is not idle but"
                    f" {state.robot_mode.name[1:]}: release its stops, unlock"
                    " its joints and recover from errors in Desk"
                )
            self._controller = controllers.IntegratedVelocity()
            self._controller.set_control(np.zeros(7))
            self._panda.start_controller(self._controller)
        except RuntimeError as error:
            raise RemoSplatError(f"{host}: {one_line(error)}") from error

    def state(self) -> Any:
        """Returns the latest `RobotState` of libfranka."""
        return self._panda.get_state()

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Makes the joints move at these rates, shape (7,) [rad/s]."""
        self._controller.set_control(velocity)

    def problem(self) -> str:
        """Says why the arm has stopped by itself; empty while it has not."""
        try:
            self._panda.raise_error()
        except RuntimeError as error:
            return one_line(error)
        return ""

    def close(self) -> None:
        """Gives up control; the arm should stand still by then."""
        self._panda.stop_controller()
