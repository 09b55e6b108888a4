"""`SimulatedPanda`: the arm and its driver, without the rigid bodies."""

import dataclasses as dc
from enum import IntEnum

import numpy as np
from drake import lcmt_panda_status

from remosplat_drake.hardware.drivers.panda_commands import (
    JOINTS,
    PandaCommands,
)
from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    POSITION_LOWER,
    POSITION_UPPER,
    TICK,
    JointCommand,
    next_command,
)

COLLISION_TORQUE = 20.0
"""External torque on a joint that makes the arm stop [N m]: the threshold in
libfranka's own examples."""


class RobotMode(IntEnum):
    """Values of lcmt_panda_status.robot_mode, as libfranka numbers them."""

    OTHER = 0
    IDLE = 1
    MOVE = 2
    GUIDING = 3
    REFLEX = 4
    USER_STOPPED = 5
    RECOVERY = 6


@dc.dataclass(frozen=True, eq=False)
class ArmMeasurement:
    """What the arm's sensors measure, each of shape (7,).

    Attributes:
        position: Joint positions [rad].
        velocity: Joint rates [rad/s].
        torque: Motor torques [N m].
        external: Torques on the joints by what touches the arm [N m].
    """

    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    external: np.ndarray


class SimulatedPanda:
    """The arm and its driver: commands in, joint rates and statuses out.

    A collision or a joint at the end of its range is a reflex: the arm brakes
    and stays where it is, whatever it is told, until `recover`.

    Attributes:
        commands: The driver's latest velocity command.
        mode: The arm's mode; it obeys commands in `MOVE` only.
        success_rate: Share of the latest packets that reached the arm, as
            statuses report it.
    """

    def __init__(self):
        """Starts in velocity control, at rest."""
        self.commands = PandaCommands()
        self.mode = RobotMode.MOVE
        self.success_rate = 1.0
        self._command: JointCommand = AT_REST
        self._ticks = 0

    def stop(self, mode: RobotMode) -> None:
        """Makes the arm brake and ignore commands, in the given mode."""
        self.mode = mode

    def recover(self) -> None:
        """Returns to velocity control, as automatic error recovery does."""
        self.mode = RobotMode.MOVE

    def step(self, now: int, measured: ArmMeasurement) -> np.ndarray:
        """Advances the arm's command by one millisecond.

        Args:
            now: The driver's wall clock [us].
            measured: What the arm's sensors measure now.

        Returns:
            Joint rates, shape (7,) [rad/s].
        """
        target = self.commands.velocity(now)
        if self.mode == RobotMode.MOVE and violates(measured, target):
            self.stop(RobotMode.REFLEX)
        if self.mode != RobotMode.MOVE:
            target = np.zeros(JOINTS)
        self._command = next_command(target, self._command)
        self._ticks += 1
        return self._command.velocity

    def status(self, now: int, measured: ArmMeasurement) -> lcmt_panda_status:
        """Makes the status message, filled as drake-franka-driver fills it."""
        message = lcmt_panda_status()
        message.utime = now
        message.num_joints = JOINTS
        message.joint_position = measured.position.tolist()
        desired = measured.position + TICK * self._command.velocity
        message.joint_position_desired = desired.tolist()
        message.joint_velocity = measured.velocity.tolist()
        message.joint_velocity_desired = self._command.velocity.tolist()
        message.joint_acceleration_desired = self._command.acceleration.tolist()
        torque = measured.torque.tolist()
        message.joint_torque = torque
        message.joint_torque_desired = torque
        message.joint_torque_external = measured.external.tolist()
        moving = self.mode == RobotMode.MOVE
        message.control_command_success_rate = moving * self.success_rate
        message.robot_mode = int(self.mode)
        message.robot_utime = round(1e6 * TICK * self._ticks)
        return message


def violates(measured: ArmMeasurement, target: np.ndarray) -> bool:
    """Tells whether the arm would stop by a reflex.

    It does at a collision, and where a joint beyond its position limit is
    told to go on; it may move back.

    Args:
        measured: What the arm's sensors measure.
        target: Commanded joint rates, shape (7,) [rad/s].
    """
    q = measured.position
    beyond = ((q < POSITION_LOWER) & (target < 0)) | (
        (q > POSITION_UPPER) & (target > 0)
    )
    collision = np.abs(measured.external) > COLLISION_TORQUE
    return bool((beyond | collision).any())
