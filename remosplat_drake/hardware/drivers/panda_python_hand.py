"""`PandaPythonHand`: drives a real Franka hand through panda-python."""

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.hardware.drivers.franka_host import (
    check_reachable,
    one_line,
)

SPEED = 0.1
"""Speed of the fingers' opening [m/s]."""

_NARROWER = 1e-3


class PandaPythonHand:
    """A `HandLink` that has been homed and is ready to move."""

    def __init__(self, host: str):
        """Connects, and opens the fingers once to determine their range.

        Args:
            host: Name or address of the arm's controller.

        Raises:
            RemoSplatError: panda-python is not installed, or the hand does not
                answer.
        """
        try:
            from panda_py import libfranka
        except ImportError as error:
            raise MissingExtraError("the Panda driver", "panda") from error
        check_reachable(host, hand=True)
        try:
            self._gripper = libfranka.Gripper(host)
            self._gripper.homing()
        except RuntimeError as error:
            raise RemoSplatError(f"{host}: {one_line(error)}") from error
        self._force = 0.0

    def measure(self) -> tuple[float, float]:
        """Returns the fingers' opening and the force of each finger [m, N].

        The hand does not measure force. During a grasp, the result is the
        commanded force.

        Raises:
            RemoSplatError: The connection is lost.
        """
        try:
            state = self._gripper.read_once()
        except RuntimeError as error:
            raise RemoSplatError(f"the hand: {one_line(error)}") from error
        return state.width, self._force if state.is_grasped else 0.0

    def go_to(self, width: float, force: float) -> None:
        """Moves the fingers; if they close, they may grasp an object.

        Args:
            width: Commanded opening [m].
            force: Gripping force [N].

        Raises:
            RemoSplatError: The hand rejects the command, or the connection is
                lost.
        """
        widens = width > self.measure()[0] - _NARROWER
        self._force = force
        try:
            if widens:
                self._gripper.move(width, SPEED)
            else:
                # An object may stop the fingers at any width.
                self._gripper.grasp(width, SPEED, force, 1.0, 1.0)
        except RuntimeError as error:
            raise RemoSplatError(f"the hand: {one_line(error)}") from error
