"""The braking ramp: the quickest straight way to a standstill."""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel


def braking_command(
    u: np.ndarray, acceleration_limit: np.ndarray, dt: float
) -> np.ndarray:
    """Computes the next command of the ramp to zero within acceleration limits.

    The whole vector shrinks by one factor, so that the robot keeps to the
    path it was on; the joint that needs longest sets the pace.

    Args:
        u: The velocity command that is being executed, shape (n_u,)
            [rad/s, m/s].
        acceleration_limit: Bounds on |du/dt|, shape (n_u,) [rad/s^2, m/s^2].
        dt: Control period [s].

    Returns:
        The command of the next tick, shape (n_u,); zero if u is not finite.
    """
    # Copies, since numba compiles anew for arrays that may not be written: it
    # must not do so while a robot brakes.
    return next_on_ramp(
        np.array(u, float), np.array(acceleration_limit, float), float(dt)
    )


@kernel
def next_on_ramp(u, acceleration_limit, dt):
    """Computes what `braking_command` does, for kernels, shape (n_u,).

    Args:
        u: The velocity command that is being executed, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        dt: Control period [s].
    """
    if not np.isfinite(u).all():
        return np.zeros_like(u)
    steps = braking_steps(u, acceleration_limit, dt)
    return np.zeros_like(u) if steps <= 1.0 else u * (1.0 - 1.0 / steps)


@kernel
def braking_steps(u, acceleration_limit, dt) -> float:
    """Counts the ticks of the braking ramp from u, not rounded.

    Args:
        u: The command at the start of the ramp, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        dt: Control period [s].
    """
    steps = 0.0
    for j in range(len(u)):
        steps = max(steps, abs(u[j]) / (acceleration_limit[j] * dt))
    return steps


@kernel
def stopping_times(u, acceleration_limit, dt):
    """Computes when a tick with u and each tick of its braking ramp end.

    Time is counted as if u were held: the ramp shrinks u evenly, by the
    factors 1 - 1/n, 1 - 2/n, ..., and the way of each tick shrinks with it.

    Args:
        u: The command of the first tick, shape (n_u,).
        acceleration_limit: Bounds on |du/dt| of the ramp, shape (n_u,).
        dt: Control period [s].

    Returns:
        The ends of the ticks, ascending, shape (k,) [s].
    """
    steps = max(braking_steps(u, acceleration_limit, dt), 1.0)
    times = np.empty(math.ceil(steps))
    time = 0.0
    for k in range(len(times)):
        time += dt * (1.0 - k / steps)
        times[k] = time
    return times
