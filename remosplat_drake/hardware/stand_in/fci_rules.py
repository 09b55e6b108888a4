"""`FciRules`: a Franka arm's rules for velocity commands, and for aborts.

These are the rules of the robot's side of the Franka Control Interface in joint
velocity mode, as Franka documents them. The robot expects a command every
millisecond, and limits velocity, acceleration and jerk, computed by backward
differences. If a packet is lost, the robot continues with constant
acceleration. After twenty lost packets in a row, it aborts the motion.
"""

from collections import deque

import numpy as np

from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    PANDA,
    POSITION_LOWER,
    POSITION_UPPER,
    TICK,
    JointCommand,
    limit_rate,
)
from remosplat_drake.hardware.stand_in.simulated_arm import (
    COLLISION_TORQUE,
    ArmMeasurement,
    RobotMode,
)

LOST_LIMIT = 20
"""The arm aborts its motion after this many lost packets in a row."""

_WINDOW = 100


class FciRules:
    """The arm's own controller in joint velocity mode, in 1 ms steps.

    Attributes:
        mode: `IDLE`, `MOVE` if it follows commands, or the mode of a stop.
        error: Libfranka's name of the error that aborted the latest motion;
            empty if none did.
        command: The arm's desired motion: from a packet, extrapolated, or on
            its own ramp after an abort.
        collision_torque: Magnitudes of external torques from which a contact
            counts as a collision, shape (7,) [N m].
    """

    def __init__(self):
        """Starts idle."""
        self.mode = RobotMode.IDLE
        self.error = ""
        self.command: JointCommand = AT_REST
        self.collision_torque = np.full(7, COLLISION_TORQUE)
        self._lost = 0
        self._heard: deque[bool] = deque(maxlen=_WINDOW)

    @property
    def success_rate(self) -> float:
        """Fraction of the latest 100 packets that arrived; 0 at rest."""
        moves = self.mode == RobotMode.MOVE
        return sum(self._heard) / len(self._heard) if moves else 0.0

    def begin(self) -> None:
        """Begins a motion, from rest."""
        self.mode, self.error = RobotMode.MOVE, ""
        self.command, self._lost = AT_REST, 0
        self._heard.clear()
        self._heard.append(True)

    def abort(self, error: str, mode: RobotMode = RobotMode.REFLEX) -> None:
        """Aborts the motion; the arm brakes by its own ramp."""
        self.mode, self.error = mode, error

    def recover(self) -> None:
        """Clears the error, as automatic error recovery does."""
        self.mode, self.error = RobotMode.IDLE, ""

    def step(
        self,
        measured: ArmMeasurement,
        packet: np.ndarray | None,
        is_last: bool = False,
    ) -> JointCommand:
        """Advances the arm's desired motion by one millisecond.

        Args:
            measured: Measurements of the arm's sensors.
            packet: The command that has arrived in time, shape (7,) [rad/s];
                None if no command has.
            is_last: Whether the command ends the motion.
        """
        if self.mode == RobotMode.MOVE:
            wanted = self._wanted(packet, is_last)
            self.error = self._lost_connection() or error_of(
                wanted, self.command, measured, self.collision_torque
            )
            if not self.error:
                self.command = wanted
                self.mode = RobotMode.IDLE if is_last else RobotMode.MOVE
                return wanted
            self.abort(self.error)
        self.command = limit_rate(np.zeros(7), self.command)
        return self.command

    def _wanted(self, packet: np.ndarray | None, is_last: bool) -> JointCommand:
        self._heard.append(packet is not None)
        last = self.command
        if packet is None:
            self._lost += 1
            return JointCommand(
                last.velocity + TICK * last.acceleration, last.acceleration
            )
        self._lost = 0
        velocity = np.zeros(7) if is_last else packet
        return JointCommand(velocity, (velocity - last.velocity) / TICK)

    def _lost_connection(self) -> str:
        lost = self._lost >= LOST_LIMIT
        return "communication_constraints_violation" if lost else ""


def error_of(
    wanted: JointCommand,
    last: JointCommand,
    measured: ArmMeasurement,
    collision_torque: np.ndarray,
) -> str:
    """Returns the error for which the arm rejects a command.

    Args:
        wanted: The command.
        last: The command of the previous millisecond.
        measured: Measurements of the arm's sensors.
        collision_torque: External torques that count as a collision, shape (7,)
            [N m].

    Returns:
        Libfranka's name of the error; empty if there is none.
    """
    jerk = (wanted.acceleration - last.acceleration) / TICK
    q, motion = measured.position, "joint_motion_generator_"
    outward = ((q < POSITION_LOWER) & (wanted.velocity < 0)) | (
        (q > POSITION_UPPER) & (wanted.velocity > 0)
    )
    for name, wrong in (
        ("joint_reflex", np.abs(measured.external) > collision_torque),
        (f"{motion}position_limits_violation", outward),
        (
            f"{motion}velocity_limits_violation",
            np.abs(wanted.velocity) > PANDA.velocity,
        ),
        (
            f"{motion}velocity_discontinuity",
            np.abs(wanted.acceleration) > PANDA.acceleration,
        ),
        (f"{motion}acceleration_discontinuity", np.abs(jerk) > PANDA.jerk),
    ):
        if wrong.any():
            return name
    return ""
