"""The braking ramp: the quickest straight way to a standstill."""

import math

import numpy as np


def braking_command(
    u: np.ndarray, acceleration_limit: np.ndarray, dt: float
) -> np.ndarray:
    """The next command on a ramp to zero, within the acceleration limits.

    The whole vector shrinks by one factor, so that the robot keeps to the
    path it was on; the joint that needs longest sets the pace.

    Args:
        u: The command that is being executed, shape (n_u,).
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        dt: Control period [s].
    """
    if not np.isfinite(u).all():
        return np.zeros_like(u)
    steps = braking_steps(u, acceleration_limit, dt)
    return np.zeros_like(u) if steps <= 1.0 else u * (1.0 - 1.0 / steps)


def braking_steps(
    u: np.ndarray, acceleration_limit: np.ndarray, dt: float
) -> float:
    """How many ticks the ramp from u takes, not rounded."""
    return float(np.max(np.abs(u) / (acceleration_limit * dt), initial=0.0))


def braking_fractions(
    u: np.ndarray, acceleration_limit: np.ndarray, dt: float
) -> np.ndarray:
    """Factors on u along its own ramp, from the tick after it, shape (k,).

    The ramp shrinks u evenly: 1 - 1/n, 1 - 2/n, ..., the last one positive.
    """
    steps = braking_steps(u, acceleration_limit, dt)
    count = max(math.ceil(steps) - 1, 0)
    return 1.0 - np.arange(1, count + 1) / max(steps, 1.0)
