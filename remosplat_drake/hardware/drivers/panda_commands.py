"""Rules of an arm's driver for `PANDA_COMMAND` in velocity mode.

drake-franka-driver has the same rules, with one exception. A command is valid
while its stamp differs from the driver's clock by less than the expiry time, to
the past or the future. Without a valid command, the arm is commanded to rest. A
command with a braking ramp only has to be valid on arrival. It is held for 1.5
control periods, and followed by the ramp to rest, which the controller has
verified. The exception is a message that is not a velocity command:
drake-franka-driver exits, but this driver counts and ignores the message, so
that a wrong packet does not end a motion.
"""

import numpy as np
from drake import lcmt_panda_command
from pydrake.manipulation import PandaControlMode

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.latest_ramp import LatestRamp
from remosplat_drake.hardware.wire.channels import (
    COMMAND_EXPIRY,
    COMMAND_RAMP,
    PANDA_COMMAND,
)
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    from_utime,
    is_expired,
)

JOINTS = 7
"""Number of the Panda's joints."""


class CommandError(RemoSplatError):
    """Raised if a message is not a valid velocity command of an arm."""

    def __init__(self, field: str, problem: str):
        super().__init__(f"{PANDA_COMMAND}: {field}: {problem}")


def checked_velocity(
    message: lcmt_panda_command, joints: int = JOINTS
) -> np.ndarray:
    """Returns the joint rates of a velocity command, shape (n,) [rad/s].

    Args:
        message: The message.
        joints: Number n of the arm's joints.

    Raises:
        CommandError: The message is not a velocity command, has values that are
            not finite, or has the wrong number of joints.
    """
    mode = int(PandaControlMode.kVelocity)
    if message.control_mode_expected != mode:
        raise CommandError(
            "control_mode_expected",
            f"the driver is in velocity mode ({mode}),"
            f" got {message.control_mode_expected}",
        )
    for field, expected in (
        ("num_joint_velocity", joints),
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


class ArmCommands:
    """The arm's latest velocity command, until it expires.

    Attributes:
        received: Number of commands so far.
        broken: Number of messages that are not velocity commands.
        complaint: Error of the latest such message; empty if there was no such
            message.
        expired: Number of commands that expired before a newer command came.
    """

    def __init__(self, joints: int = JOINTS, expiry: float = COMMAND_EXPIRY):
        """Starts without a command.

        Args:
            joints: Number n of the arm's joints.
            expiry: A command expires if its stamp differs from the driver's
                clock by more than this time [s].
        """
        self._joints, self._expiry = joints, expiry
        self._velocity: np.ndarray | None = None
        self._utime = 0
        self._came: int | None = None
        self._ramp = LatestRamp()
        self.received = 0
        self.broken = 0
        self.complaint = ""
        self.expired = 0

    def hear(self, channel: str, data: bytes) -> None:
        """Processes a command, or the ramp of the next command.

        Args:
            channel: `COMMAND_RAMP`, or the channel of the commands.
            data: The encoded packet; a malformed packet is ignored.
        """
        if channel == COMMAND_RAMP:
            self._ramp.receive(data)
        else:
            self.receive(data)

    def receive(self, data: bytes) -> None:
        """Processes an lcmt_panda_command; only counts a malformed one."""
        try:
            self._take(data)
        except CommandError as error:
            self.broken += 1
            self.complaint = str(error)

    def _take(self, data: bytes) -> None:
        try:
            message = decode(lcmt_panda_command, data)
        except BrokenMessage as error:
            raise CommandError("message", str(error)) from error
        self._velocity = checked_velocity(message, self._joints)
        self._utime, self._came = message.utime, None
        self.received += 1

    def velocity(self, now: int) -> np.ndarray:
        """Returns the present setpoint; zeros after the end of the command.

        Args:
            now: The driver's wall clock [us].

        Returns:
            Joint rates, shape (n,) [rad/s].
        """
        if self._velocity is None:
            return np.zeros(self._joints)
        share = self._share(now)
        if not share:
            self._velocity = None
            self.expired += 1
            return np.zeros(self._joints)
        return share * self._velocity

    def _share(self, now: int) -> float:
        """Present factor by which the command is scaled, 0 to 1."""
        if self._came is None:
            self._came = now
        age = from_utime(now - self._came)
        ramp = self._ramp.of(self._utime)
        if ramp is None:
            return float(not is_expired(self._utime, now, self._expiry))
        # The age is unknown if the clock has gone back.
        if age < 0 or is_expired(self._utime, self._came, self._expiry):
            return 0.0
        return ramp.share(age)
