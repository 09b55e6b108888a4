"""The braking ramp: the fastest stop that keeps the direction of the command.

A station executes a command until the next one arrives, for at most `HELD`
periods. Afterwards it brakes by itself, by one step of the ramp in each period.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel

HELD = 1.5
"""Periods for which a station executes a command without a newer one."""


def braking_command(
    u: np.ndarray, acceleration_limit: np.ndarray, time: float
) -> np.ndarray:
    """Computes the next command of the ramp to zero within acceleration limits.

    All entries shrink by the same factor, so that the robot stays on its path.
    The axis that needs the longest time to stop determines the factor.

    Args:
        u: The velocity command that was sent last, shape (n_u,) [rad/s, m/s].
        acceleration_limit: Bounds on |du/dt|, shape (n_u,) [rad/s^2, m/s^2].
        time: Time since that command [s]; one control period if no tick is
            late.

    Returns:
        The command to send now, shape (n_u,); zero if u is not finite.
    """
    # Copies, since Numba would compile again for read-only arrays, which must
    # not happen while a robot brakes.
    return next_on_ramp(
        np.array(u, float), np.array(acceleration_limit, float), float(time)
    )


@kernel
def next_on_ramp(u, acceleration_limit, time):
    """Computes the same as `braking_command`, for kernels, shape (n_u,).

    Args:
        u: The velocity command that was sent last, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        time: Time since that command [s].
    """
    if not np.isfinite(u).all():
        return np.zeros_like(u)
    steps = braking_steps(u, acceleration_limit, time)
    return np.zeros_like(u) if steps <= 1.0 else u * (1.0 - 1.0 / steps)


def executed_command(
    u: np.ndarray, acceleration_limit: np.ndarray, dt: float, age: float
) -> np.ndarray:
    """Computes the velocities that a station executes `age` after a command.

    Args:
        u: The command, shape (n_u,) [rad/s, m/s].
        acceleration_limit: Bounds on |du/dt|, shape (n_u,) [rad/s^2, m/s^2].
        dt: Control period [s].
        age: Time since the command began to act [s].

    Returns:
        The velocities, shape (n_u,); zero if u is not finite.
    """
    # Copies, as in `braking_command`.
    limit = np.array(acceleration_limit, float)
    return held_command(np.array(u, float), limit, float(dt), float(age))


@kernel
def held_command(u, acceleration_limit, dt, age):
    """Computes the same as `executed_command`, for kernels, shape (n_u,).

    Args:
        u: The command, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        dt: Control period [s].
        age: Time since the command began to act [s].
    """
    if not np.isfinite(u).all():
        return np.zeros_like(u)
    return held_share(age, dt, braking_time(u, acceleration_limit)) * u


def spare_time(dt: float) -> float:
    """Computes the time beyond a tick for which a station holds a command [s].

    Args:
        dt: Control period [s].
    """
    return (HELD - 1.0) * dt


@helper
def held_share(age: float, dt: float, ramp: float) -> float:
    """Computes the fraction of a command that a station executes, 0 to 1.

    Args:
        age: Time since the command began to act [s].
        dt: Control period [s].
        ramp: Duration of the ramp from the command to zero [s].
    """
    steps = math.floor(age / dt - HELD) + 1
    if steps <= 0:
        return 1.0
    return max(1.0 - steps * dt / ramp, 0.0) if ramp > 0.0 else 0.0


def periods_between(before: float, now: float, dt: float) -> float:
    """Counts the control periods between two ticks, at least one.

    Skipped ticks are counted, too. The result is one if there was no tick
    before, or if the clock went back.

    Args:
        before: Time of the previous tick [s]; NaN for none.
        now: Time of the tick [s].
        dt: Control period [s].
    """
    periods = (now - before) / dt
    return max(float(round(periods)), 1.0) if math.isfinite(periods) else 1.0


@helper
def braking_time(u, acceleration_limit) -> float:
    """Computes the duration of the ramp from a command to zero [s].

    Args:
        u: The command, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
    """
    longest = 0.0
    for j in range(len(u)):
        longest = max(longest, abs(u[j]) / acceleration_limit[j])
    return longest


@helper
def braking_steps(u, acceleration_limit, dt) -> float:
    """Computes the number of ticks of the braking ramp from u, not rounded.

    Args:
        u: The command at the start of the ramp, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        dt: Control period [s].
    """
    return braking_time(u, acceleration_limit) / dt


@kernel
def stopping_times(u, acceleration_limit, dt, spare):
    """Computes the path times at which the ticks of u and of its ramp end.

    A path time is the time in which the robot would reach the same place with u
    held. The ramp multiplies u by 1 - 1/n, 1 - 2/n, ..., so each of its ticks
    covers that fraction of a tick's path. The last entry is the path time at
    which a station comes to rest if no further command arrives: it holds u for
    longer than a tick.

    Args:
        u: The command of the first tick, shape (n_u,).
        acceleration_limit: Bounds on |du/dt| of the ramp, shape (n_u,).
        dt: Length of the ticks [s].
        spare: Time beyond one tick for which a station holds a command [s].

    Returns:
        The path times of the ends of the ticks, and that of the station's own
        stop, ascending, shape (k,) [s].
    """
    steps = max(braking_steps(u, acceleration_limit, dt), 1.0)
    times = np.empty(math.ceil(steps) + 1)
    time = 0.0
    for k in range(len(times) - 1):
        time += dt * (1.0 - k / steps)
        times[k] = time
    times[-1] = time + spare
    return times
