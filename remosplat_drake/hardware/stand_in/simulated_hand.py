"""`SimulatedHand`: simulates the Franka hand's driver, without dynamics."""

import numpy as np
from drake import lcmt_schunk_wsg_status

from remosplat_drake.hardware.drivers.hand_messages import (
    PERIOD,
    hand_status,
    read_command,
)


class SimulatedHand:
    """Stores the latest command to the gripper, and makes statuses at 10 Hz.

    As in the hand's real driver, a command does not expire: it is valid until
    the next command.

    Attributes:
        command: Commanded width and bound on the force, shape (2,) [m, N].
    """

    def __init__(self, width: float, force: float = 10.0):
        """Starts with a constant width.

        Args:
            width: Opening of the fingers [m].
            force: Bound on the gripping force [N].
        """
        self.command = np.array([width, force])
        self._next_status = 0.0

    def receive(self, data: bytes) -> None:
        """Processes an encoded command; a malformed command is ignored."""
        command = read_command(data)
        if command is not None:
            self.command = np.array(command)

    def status(
        self, now: int, t: float, state: np.ndarray
    ) -> lcmt_schunk_wsg_status | None:
        """Returns the status message if one is due, else None.

        Args:
            now: The driver's wall clock [us].
            t: The robot's clock [s].
            state: Opening of the fingers, its rate, and the force of each
                finger, shape (3,) [m, m/s, N].
        """
        if t < self._next_status:
            return None
        self._next_status += PERIOD
        width, rate, force = map(float, state)
        return hand_status(width, rate, force, now)
