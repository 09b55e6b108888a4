"""`SimulatedHand`: the Franka hand and its driver."""

import math
import struct

import numpy as np
from drake import lcmt_schunk_wsg_command, lcmt_schunk_wsg_status

PERIOD = 0.1
"""Period of the hand driver's loop [s]."""

_MILLIMETRES = 1e3


class SimulatedHand:
    """Holds the latest width; reports ten times a second.

    A command moves the fingers once and then counts until another one comes,
    as the hand's driver has it: there is no expiry.
    """

    def __init__(self, width: float, force: float = 10.0):
        """Starts holding a width.

        Args:
            width: Opening of the fingers [m].
            force: Bound on the gripping force [N].
        """
        self.command = np.array([width, force])
        self._next_status = 0.0

    def receive(self, data: bytes) -> None:
        """Takes a message from the wire; one that is none is ignored."""
        try:
            message = lcmt_schunk_wsg_command.decode(data)
        except (ValueError, struct.error):
            return
        command = (message.target_position_mm, message.force)
        if all(map(math.isfinite, command)):
            self.command = np.array(
                [message.target_position_mm / _MILLIMETRES, message.force]
            )

    def status(
        self, now: int, t: float, state: np.ndarray
    ) -> lcmt_schunk_wsg_status | None:
        """The status message if one is due.

        Args:
            now: The driver's wall clock [us].
            t: The robot's clock [s].
            state: Width and its rate, shape (2,) [m, m/s].
        """
        if t < self._next_status:
            return None
        self._next_status += PERIOD
        message = lcmt_schunk_wsg_status()
        message.utime = now
        message.actual_position_mm = float(_MILLIMETRES * state[0])
        message.actual_speed_mm_per_s = float(_MILLIMETRES * state[1])
        return message
