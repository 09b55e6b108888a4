"""Computes configurations on a path with piecewise constant velocities."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, named, reals
from remosplat_drake.robot.kinematics import advance


class PathArrays(NamedTuple):
    """A path of s pieces, on each of which velocities are constant.

    On each piece, the arm's joints move on a straight line, and the base on an
    arc.

    Attributes:
        starts: Configurations at the start of each piece, shape (s, n_q) [rad,
            m].
        rates: Velocities on the pieces, shape (s, n_u) [rad/s, m/s].
        since: Start time of each piece; the first is 0, shape (s,) [s].
        n_base: Number of base commands, 3, 2 or 0.
        times: Times of the samples, ascending, up to the path's end, shape (k,)
            [s]. They include the end times of all pieces.
        clock: Earliest clock time of the robot at each sample, for which movers
            are predicted, shape (k,) [s].
        peak: Greatest actual or commanded speed of each axis on the path, shape
            (n_u,) [rad/s, m/s].
        tube: Bounds of deviations from the path, divided by `peak`, shape
            (n_u,) [s].
    """

    starts: np.ndarray
    rates: np.ndarray
    since: np.ndarray
    n_base: int
    times: np.ndarray
    clock: np.ndarray
    peak: np.ndarray
    tube: np.ndarray


PATH = named(
    PathArrays,
    *(reals(2), reals(2), reals(1), WHOLE),
    *(reals(1), reals(1), reals(1), reals(1)),
)
"""Numba's type of a path."""


@kernel(returns=PATH)
def held(q, u, n_base, times, clock) -> PathArrays:
    """Makes the path of a command that is held.

    Args:
        q: Configuration at which the path starts, shape (n_q,) [rad, m].
        u: The command, shape (n_u,).
        n_base: Number of base commands, 3, 2 or 0.
        times: Times of the samples, ascending, shape (k,) [s].
        clock: Earliest clock time of the robot at each sample, shape (k,) [s].
    """
    starts, rates = np.empty((1, len(q))), np.empty((1, len(u)))
    _set_row(starts, 0, q)
    _set_row(rates, 0, u)
    return PathArrays(
        starts,
        rates,
        np.zeros(1),
        n_base,
        times,
        clock,
        np.abs(u),
        np.zeros(len(u)),
    )


@helper
def place(path, time):
    """Computes the configuration at a time on a path, shape (n_q,).

    Args:
        path: The `PathArrays`.
        time: Time on the path [s].
    """
    k = len(path.since) - 1
    while k > 0 and path.since[k] >= time:
        k -= 1
    rest = time - path.since[k]
    return advance(path.starts[k], path.rates[k], path.n_base, rest)


@kernel
def places(path, times):
    """Computes the configurations at k times, shape (k, n_q)."""
    found = np.empty((len(times), path.starts.shape[1]))
    for i in range(len(times)):
        _set_row(found, i, place(path, times[i]))
    return found


@kernel
def chain(q, rates, spans, n_base):
    """Computes the configurations at the starts of consecutive pieces.

    Args:
        q: Configuration at the start, shape (n_q,).
        rates: Velocities on the pieces, shape (s, n_u).
        spans: Durations of the pieces, shape (s,) [s].
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
    """Copies a vector to a row; NumPy's assignment takes longer to compile."""
    for j in range(len(values)):
        out[row, j] = values[j]
