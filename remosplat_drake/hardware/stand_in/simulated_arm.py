"""`SimulatedArm`: simulates an arm's driver and its rules, without dynamics."""

import dataclasses as dc
from enum import IntEnum

import numpy as np
from drake import lcmt_panda_status

from remosplat_drake.hardware.drivers.panda_commands import ArmCommands
from remosplat_drake.hardware.drivers.panda_limits import TICK, JointCommand

COLLISION_TORQUE = 20.0
"""The arm stops if the external torque on a joint exceeds this value [N m; N
for prismatic joints], as in libfranka's examples.
"""


class RobotMode(IntEnum):
    """Values of lcmt_panda_status.robot_mode, which are libfranka's."""

    OTHER = 0
    IDLE = 1
    MOVE = 2
    GUIDING = 3
    REFLEX = 4
    USER_STOPPED = 5
    RECOVERY = 6


@dc.dataclass(frozen=True, eq=False)
class ArmMeasurement:
    """Sensor measurements of an arm with n joints, each of shape (n,).

    Attributes:
        position: Joint positions [rad].
        velocity: Joint rates [rad/s].
        torque: Motor torques [N m].
        external: Torques on the joints by contact [N m].
    """

    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray
    external: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class ArmLimits:
    """Limits of an arm of n joints, each of shape (n,).

    Attributes:
        lower: Lower position limits of the joints [rad, m].
        upper: Upper position limits of the joints [rad, m].
        velocity: Greatest joint rates [rad/s, m/s].
        acceleration: Greatest joint accelerations [rad/s^2, m/s^2].
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


class SimulatedArm:
    """Simulates an arm's driver: converts commands to rates and statuses.

    A collision, or a joint at the end of its range, causes a reflex: the arm
    brakes and ignores commands until `recover`.

    Attributes:
        commands: The driver's latest velocity command.
        mode: The arm's mode; the arm follows commands only in `MOVE`.
        success_rate: Fraction of the latest packets that reached the arm, which
            statuses report.
    """

    def __init__(self, limits: ArmLimits):
        """Starts in velocity control, at rest.

        Args:
            limits: The arm's limits.
        """
        n = len(limits.lower)
        self.commands = ArmCommands(n)
        self.mode = RobotMode.MOVE
        self.success_rate = 1.0
        self._limits = limits
        self._command = JointCommand(np.zeros(n), np.zeros(n))
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
            measured: The present measurements of the arm's sensors.

        Returns:
            Joint rates, shape (n,) [rad/s].
        """
        target = self.commands.velocity(now)
        limits = self._limits
        if self.mode == RobotMode.MOVE and violates(measured, target, limits):
            self.stop(RobotMode.REFLEX)
        if self.mode != RobotMode.MOVE:
            target = np.zeros(len(target))
        self._command = self._next(target)
        self._ticks += 1
        return self._command.velocity

    def _next(self, target: np.ndarray) -> JointCommand:
        """Returns the next command, within the bounds on acceleration."""
        limits, before = self._limits, self._command.velocity
        target = np.clip(target, -limits.velocity, limits.velocity)
        step = limits.acceleration * TICK
        change = np.clip(target - before, -step, step)
        return JointCommand(before + change, change / TICK)

    def status(self, now: int, measured: ArmMeasurement) -> lcmt_panda_status:
        """Makes the status message, like drake-franka-driver's."""
        message = lcmt_panda_status()
        message.utime = now
        message.num_joints = len(measured.position)
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


def violates(
    measured: ArmMeasurement, target: np.ndarray, limits: ArmLimits
) -> bool:
    """Returns whether the arm would stop by a reflex.

    A collision causes a reflex, and so does a command that moves a joint
    farther beyond its position limit.

    Args:
        measured: Measurements of the arm's sensors.
        target: Commanded joint rates, shape (n,) [rad/s].
        limits: The arm's limits.
    """
    q = measured.position
    beyond = ((q < limits.lower) & (target < 0)) | (
        (q > limits.upper) & (target > 0)
    )
    collision = np.abs(measured.external) > COLLISION_TORQUE
    return bool((beyond | collision).any())
