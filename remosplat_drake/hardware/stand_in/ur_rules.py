"""`UrRules`: simulates a Universal Robots controller with ur_rtde's script.

The script of ur_rtde is a loop on the controller. It reads a command from an
integer register, and executes the command. In another register, it reports that
the command is done. When the client has removed the command, it reports that it
is ready again. Speed commands are a stream without such reports. This module
simulates this loop, with the commands that a velocity controller needs, and the
controller's own stops.
"""

import math
from enum import IntEnum

import numpy as np

JOINTS = 6
"""Number of the arm's joints."""

READY, DONE = 1, 2
"""States of the script: ready for a command, or done with a command."""

STOP_DECELERATION = 20.0
"""Deceleration of protective and emergency stops [rad/s^2]."""


class Command(IntEnum):
    """Commands to the script, with their numbers in ur_rtde."""

    NONE = 0
    SPEED_J = 9
    SPEED_STOP = 15
    SET_WATCHDOG = 35
    STOP_SCRIPT = 255


class SafetyMode(IntEnum):
    """Values of safety_mode."""

    NORMAL = 1
    PROTECTIVE_STOP = 3
    ROBOT_EMERGENCY_STOP = 7


class UrRules:
    """Computes joint rates from the script's registers, cycle by cycle.

    Attributes:
        safety_mode: The controller's safety mode.
        is_running: Whether the script runs.
        state: The script's state in its output register.
        velocity: Joint rates that the controller commands, (6,) [rad/s].
    """

    def __init__(self):
        """Starts with the brakes released, at rest, without a script."""
        self.safety_mode = SafetyMode.NORMAL
        self.is_running = False
        self.state = 0
        self.velocity = np.zeros(JOINTS)
        self._target = np.zeros(JOINTS)
        self._acceleration = STOP_DECELERATION
        self._silence, self._longest = 0.0, math.inf

    def start_script(self) -> None:
        """Starts the script, as after an upload."""
        if self.safety_mode == SafetyMode.NORMAL:
            self.is_running, self.state = True, READY
            self._silence, self._longest = 0.0, math.inf

    def stop(self, mode: SafetyMode) -> None:
        """Makes the arm brake, and ends the script."""
        self.safety_mode = mode
        self._end(STOP_DECELERATION)

    def recover(self) -> None:
        """Unlocks the stop; a client has to upload the script again."""
        self.safety_mode = SafetyMode.NORMAL

    def _end(self, deceleration: float) -> None:
        self.is_running, self.state = False, 0
        self._target = np.zeros(JOINTS)
        self._acceleration = deceleration

    def step(
        self,
        dt: float,
        command: int,
        values: list[float],
        is_fresh: bool,
    ) -> None:
        """Runs a cycle.

        Args:
            dt: Length of the cycle [s].
            command: The command in the script's input register.
            values: The script's input registers of floats, at least six.
            is_fresh: Whether the registers were written since the previous
                cycle.
        """
        self._silence = 0.0 if is_fresh else self._silence + dt
        if self.is_running and self._silence > self._longest:
            self._end(STOP_DECELERATION)
        if self.is_running:
            self._obey(command, values)
        change = self._target - self.velocity
        largest = np.abs(change).max()
        # The rates of all axes change along a straight line, on which the axis
        # with the largest change has the given acceleration.
        share = self._acceleration * dt / max(largest, 1e-12)
        self.velocity = self.velocity + min(share, 1.0) * change

    def _obey(self, command: int, values: list[float]) -> None:
        if command == Command.NONE:
            self.state = READY
        elif command == Command.SPEED_J and self.state == READY:
            # Speed commands are a stream: each replaces the previous one, and
            # the script reports nothing.
            self._target = np.array(values[:JOINTS])
            self._acceleration = values[JOINTS]
        elif self.state == READY:
            self._execute(command, values)

    def _execute(self, command: int, values: list[float]) -> None:
        self.state = DONE
        if command == Command.SPEED_STOP:
            self._target = np.zeros(JOINTS)
            self._acceleration = values[0]
        elif command == Command.SET_WATCHDOG:
            self._longest = 1.0 / max(values[0], 1e-3)
        elif command == Command.STOP_SCRIPT:
            self._end(STOP_DECELERATION)
