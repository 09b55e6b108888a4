"""`VelocityServo`: computes the arm's command in each millisecond.

It runs in the arm's 1 kHz callback. Its only input is a setpoint with its age,
so if the process that writes setpoints fails, the arm comes to rest.
"""

import math
from collections.abc import Sequence

import numpy as np

from remosplat_drake.hardware.drivers.joint_interpolator import (
    SMOOTHING,
    JointInterpolator,
)
from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    LIMITER,
    TICK,
    JointCommand,
    limit_rate,
    violation,
)

SETPOINT_EXPIRY = 0.05
"""A setpoint older than this is ignored [s]."""

ABANDONED = 1.0
"""The motion ends after this time without a valid setpoint [s]."""

AT_REST_BELOW = 1e-6
"""A joint with the command zero counts as at rest below this rate [rad/s]."""

_SAME = 1e-6
"""Desired rates that differ from a command by at most this are the command's
[rad/s]. In one tick, such a difference is a jerk of 1 rad/s^3."""

_STAND = [0.0] * 7


class VelocityServo:
    """Follows setpoints; brakes if they are stale or invalid.

    After it has braked because of stale setpoints, it ignores setpoints until
    one of them is zero. A zero setpoint shows that the commanding program has
    noticed the stop, and starts a new motion.

    Attributes:
        command: The arm's last command.
        reason: Reason why the motion ends; empty during the motion.
        is_finished: Whether the motion has ended, with the command zero.
    """

    def __init__(self):
        """Starts at rest.

        Raises:
            MissingExtraError: Ruckig is not installed.
        """
        self._interpolator = JointInterpolator()
        self._upper = LIMITER.velocity.tolist()
        self._is_held = False
        self._stale = 0.0
        self.command: JointCommand = AT_REST
        self.reason = ""
        self.is_finished = False

    def is_executed(self, velocity: Sequence[float]) -> bool:
        """Returns whether the robot has executed the last command.

        Args:
            velocity: The robot's desired joint rates, one tick after the
                command, seven [rad/s].
        """
        return bool(np.abs(self.command.velocity - velocity).max() <= _SAME)

    def resume(
        self, velocity: Sequence[float], acceleration: Sequence[float]
    ) -> None:
        """Continues from the motion that the robot extrapolated.

        Args:
            velocity: The robot's desired joint rates, seven [rad/s].
            acceleration: Their backward difference, seven [rad/s^2].
        """
        self.command = JointCommand(np.array(velocity), np.array(acceleration))
        self._interpolator.resume(velocity, acceleration)

    def step(
        self, setpoint: Sequence[float], age: float, end: bool = False
    ) -> JointCommand:
        """Computes the command of one tick.

        Args:
            setpoint: Requested joint rates, seven [rad/s]. If they exceed their
                bounds, they are scaled by one factor.
            age: Age of the setpoint [s].
            end: Whether to end the motion when the arm is at rest.
        """
        if self.reason:
            return self._brake()
        if not all(map(math.isfinite, setpoint)):
            return self._refuse("a setpoint is not finite")
        fresh = abs(age) <= SETPOINT_EXPIRY
        self._stale = 0.0 if fresh else self._stale + TICK
        if self._is_held and fresh:
            self._is_held = any(setpoint)
        elif not fresh and not self._rests():
            self._is_held = True
        follow = fresh and not self._is_held
        target = self._within(setpoint) if follow else _STAND
        try:
            rates = self._interpolator.advance(
                target, SMOOTHING if follow else None
            )
        except ValueError as error:
            return self._refuse(str(error))
        command = _after(self.command, np.array(rates))
        problem = violation(command, self.command)
        if problem:
            return self._refuse(problem)
        self.command = command
        if self._stale > ABANDONED:
            self.reason = f"no setpoint for {ABANDONED:g} s"
        self.is_finished = bool(end or self.reason) and self._rests()
        return command

    def _within(self, setpoint: Sequence[float]) -> list[float]:
        scale = max(
            1.0,
            *(abs(v) / m for v, m in zip(setpoint, self._upper, strict=True)),
        )
        return [v / scale for v in setpoint]

    def _refuse(self, reason: str) -> JointCommand:
        """Ends the motion for a reason: the arm brakes."""
        self.reason = f"refused: {reason}"
        return self._brake()

    def _brake(self) -> JointCommand:
        """Brakes by libfranka's own law, which needs no inputs."""
        self.command = limit_rate(np.zeros(7), self.command)
        self.is_finished = self._rests()
        return self.command

    def _rests(self) -> bool:
        return bool(np.abs(self.command.velocity).max() < AT_REST_BELOW)


def _after(last: JointCommand, velocity: np.ndarray) -> JointCommand:
    return JointCommand(velocity, (velocity - last.velocity) / TICK)
