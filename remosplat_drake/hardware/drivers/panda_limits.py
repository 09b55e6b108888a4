"""Limits the rates of the Panda's velocity commands, as libfranka does.

The limits are those of Franka's table for the Panda (FER), not of the FR3.
Derivatives are backward differences over one tick, as in the robot.
"""

import dataclasses as dc
import math

import numpy as np

TICK = 1e-3
"""Period of the robot's control loop [s]."""

LOW_PASS = 30.0
"""Cutoff frequency of the low-pass filter before the limiter [Hz], as in
drake-franka-driver."""

POSITION_LOWER = np.array(
    [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]
)
"""Lower position limits of the joints, shape (7,) [rad]."""

POSITION_UPPER = np.array(
    [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]
)
"""Upper position limits of the joints, shape (7,) [rad]."""


@dc.dataclass(frozen=True, eq=False)
class RateLimits:
    """Bounds on joint velocity commands, each of shape (7,).

    Attributes:
        velocity: Bounds on |qd| [rad/s].
        acceleration: Bounds on |qdd| [rad/s^2].
        jerk: Bounds on |qddd| [rad/s^3].
    """

    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray


PANDA = RateLimits(
    velocity=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
    acceleration=np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]),
    jerk=np.array([7500.0, 3750, 5000, 6250, 7500, 10000, 10000]),
)
"""The Panda's own limits. The robot aborts its motion after a command that
exceeds them."""

_MARGIN = 1e-3
_LOST_PACKETS = 3

LIMITER = RateLimits(
    velocity=(
        PANDA.velocity - _MARGIN - _LOST_PACKETS * TICK * PANDA.acceleration
    ),
    acceleration=PANDA.acceleration - _MARGIN,
    jerk=PANDA.jerk - _MARGIN,
)
"""Limits that libfranka 0.9 sets, slightly below the robot's own.

With them, the robot stays within its limits if it extrapolates three lost
packets."""


@dc.dataclass(frozen=True, eq=False)
class JointCommand:
    """The velocity command to the joints in one tick.

    Attributes:
        velocity: Commanded joint rates, shape (7,) [rad/s].
        acceleration: Backward difference of the rates, shape (7,) [rad/s^2].
    """

    velocity: np.ndarray
    acceleration: np.ndarray


AT_REST = JointCommand(np.zeros(7), np.zeros(7))
"""The command at the start of every motion."""


def violation(
    command: JointCommand, last: JointCommand, limits: RateLimits = PANDA
) -> str:
    """Describes the robot's limit that a command violates.

    Args:
        command: The command of this tick.
        last: The command of the previous tick.
        limits: Bounds on velocity, acceleration and jerk.

    Returns:
        One line with joint, quantity and bound; empty if the robot would accept
        the command.
    """
    jerk = (command.acceleration - last.acceleration) / TICK
    for name, unit, values, bounds in (
        ("velocity", "rad/s", command.velocity, limits.velocity),
        ("acceleration", "rad/s^2", command.acceleration, limits.acceleration),
        ("jerk", "rad/s^3", jerk, limits.jerk),
    ):
        # With this order of the comparison, NaN is beyond every bound.
        beyond = ~(np.abs(values) <= bounds)
        if beyond.any():
            i = int(beyond.argmax())
            return (
                f"joint {i + 1}: {name} {values[i]:g} {unit}"
                f" beyond {bounds[i]:g}"
            )
    return ""


def low_pass(
    target: np.ndarray, previous: np.ndarray, cutoff: float = LOW_PASS
) -> np.ndarray:
    """Advances a first-order low-pass filter by one tick.

    Args:
        target: The filter's input, shape (n,).
        previous: The filter's previous output, shape (n,).
        cutoff: Cutoff frequency [Hz].
    """
    gain = TICK / (TICK + 1.0 / (2.0 * math.pi * cutoff))
    return previous + gain * (target - previous)


def limit_rate(
    target: np.ndarray, last: JointCommand, limits: RateLimits = LIMITER
) -> JointCommand:
    """Returns the command within the limits that is closest to a target.

    Near the greatest velocity, the bound on the acceleration is proportional to
    the difference from this velocity. So the jerk also stays within its bound
    when the command reaches the greatest velocity. The law is that of
    libfranka.

    Args:
        target: Wanted joint rates, finite, shape (7,) [rad/s].
        last: The command of the previous tick, which must be within the limits.
        limits: Bounds on velocity, acceleration and jerk.
    """
    slope = limits.jerk / limits.acceleration
    upper = np.minimum(
        slope * (limits.velocity - last.velocity), limits.acceleration
    )
    lower = np.maximum(
        slope * (-limits.velocity - last.velocity), -limits.acceleration
    )
    change = limits.jerk * TICK
    wanted = (target - last.velocity) / TICK
    acceleration = last.acceleration + np.clip(
        wanted - last.acceleration, -change, change
    )
    acceleration = np.clip(acceleration, lower, upper)
    return JointCommand(last.velocity + TICK * acceleration, acceleration)


def next_command(target: np.ndarray, last: JointCommand) -> JointCommand:
    """Filters and limits a target to get the robot's next command.

    Args:
        target: Wanted joint rates, finite, shape (7,) [rad/s].
        last: The command of the previous tick, which must be within the limits.
    """
    return limit_rate(low_pass(target, last.velocity), last)
