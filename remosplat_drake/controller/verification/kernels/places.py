"""Configurations on a path of pieces on which velocities are held."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.robot.kinematics import advance


@helper
def place(path, time):
    """Computes the configuration at a time on a path, shape (n_q,).

    Args:
        path: The path as `StoppingPath.arrays`.
        time: Time on the path [s].
    """
    starts, rates, since, n_base, _ = path
    k = len(since) - 1
    while k > 0 and since[k] >= time:
        k -= 1
    return advance(starts[k], rates[k], n_base, time - since[k])


@kernel
def places(path, times):
    """Computes the configurations at k times, shape (k, n_q)."""
    found = np.empty((len(times), path[0].shape[1]))
    for i in range(len(times)):
        _set_row(found, i, place(path, times[i]))
    return found


@kernel
def chain(q, rates, spans, n_base):
    """Computes where the pieces of a path begin, each at the end of another.

    Args:
        q: Configuration at the start, shape (n_q,).
        rates: Velocities on the pieces, shape (s, n_u).
        spans: How long the pieces last, shape (s,) [s].
        n_base: Number of base commands, 3, 2 or 0.

    Returns:
        The configurations, shape (s, n_q).
    """
    starts = np.empty((len(spans), len(q)))
    _set_row(starts, 0, q)
    for k in range(len(spans) - 1):
        q_then = advance(starts[k], rates[k], n_base, spans[k])
        _set_row(starts, k + 1, q_then)
    return starts


@helper
def peak_speed(rates):
    """Returns the greatest speed of each axis on the pieces, (n_u,)."""
    peak = np.zeros(rates.shape[1])
    for k in range(len(rates)):
        for j in range(len(peak)):
            peak[j] = max(peak[j], abs(rates[k, j]))
    return peak


@helper
def _set_row(out, row, values):
    """Copies a vector to a row; compiled sooner than NumPy's own way."""
    for j in range(len(values)):
        out[row, j] = values[j]
