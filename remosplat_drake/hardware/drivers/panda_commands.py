"""The arm driver's rules for `PANDA_COMMAND` in velocity mode.

They are those of drake-franka-driver. A command counts while its stamp is
within the expiry time of the driver's clock, into the past and into the
future; without one that counts the arm is told to stand still. A message
that is no velocity command at all ends the driver.
"""

import numpy as np
from drake import lcmt_panda_command
from pydrake.manipulation import PandaControlMode

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.wire.channels import COMMAND_EXPIRY, PANDA_COMMAND
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    is_expired,
)

JOINTS = 7


class CommandError(RemoSplatError):
    """A message that makes the driver give up, as the real one does."""

    def __init__(self, field: str, problem: str):
        super().__init__(f"{PANDA_COMMAND}: {field}: {problem}")


def checked_velocity(message: lcmt_panda_command) -> np.ndarray:
    """The joint rates of a velocity command, shape (7,) [rad/s].

    Raises:
        CommandError: It is not one.
    """
    mode = int(PandaControlMode.kVelocity)
    if message.control_mode_expected != mode:
        raise CommandError(
            "control_mode_expected",
            f"the driver is in velocity mode ({mode}),"
            f" got {message.control_mode_expected}",
        )
    for field, expected in (
        ("num_joint_velocity", JOINTS),
        ("num_joint_position", 0),
        ("num_joint_torque", 0),
    ):
        if getattr(message, field) != expected:
            raise CommandError(
                field, f"must be {expected}, got {getattr(message, field)}"
            )
    velocity = np.array(message.joint_velocity, float)
    if not np.isfinite(velocity).all():
        raise CommandError("joint_velocity", "has values that are not finite")
    return velocity


class PandaCommands:
    """The latest command, for as long as it counts."""

    def __init__(self, expiry: float = COMMAND_EXPIRY):
        """Starts without a command.

        Args:
            expiry: How far a stamp may be from the driver's clock [s].
        """
        self._expiry = expiry
        self._velocity: np.ndarray | None = None
        self._utime = 0
        self.received = 0
        self.expired = 0

    def receive(self, data: bytes) -> None:
        """Takes a message from the wire.

        Raises:
            CommandError: It is no velocity command.
        """
        try:
            message = decode(lcmt_panda_command, data)
        except BrokenMessage as error:
            raise CommandError("message", str(error)) from error
        self._velocity = checked_velocity(message)
        self._utime = message.utime
        self.received += 1

    def velocity(self, now: int) -> np.ndarray:
        """The joint rates to aim for, shape (7,); zeros without a command.

        Args:
            now: The driver's wall clock [us].
        """
        if self._velocity is None:
            return np.zeros(JOINTS)
        if is_expired(self._utime, now, self._expiry):
            self._velocity = None
            self.expired += 1
            return np.zeros(JOINTS)
        return self._velocity
