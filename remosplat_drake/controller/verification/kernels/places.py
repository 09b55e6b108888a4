"""Configurations on a path of pieces on which velocities are held."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, named, reals
from remosplat_drake.robot.kinematics import advance


class PathArrays(NamedTuple):
    """A sequence of s pieces, on each of which velocities are held.

    The arm's joints move on a straight line, the base on an arc.

    Attributes:
        starts: Configurations at which the pieces begin, shape (s, n_q)
            [rad, m].
        rates: Velocities on the pieces, shape (s, n_u) [rad/s, m/s].
        since: When the pieces begin, from 0 on, shape (s,) [s].
        n_base: Number of base commands, 3, 2 or 0.
        times: When the path is looked at, ascending to its end, shape (k,)
            [s]; the ends of all pieces are among them.
        clock: Earliest time of the robot at each look, shape (k,) [s], at which
            movers are evaluated.
        peak: Greatest speeds on the path, or commanded on it, shape (n_u,)
            [rad/s, m/s].
        tube: By how much positions may be off the path, as shares of `peak`,
            shape (n_u,) [s].
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
    """Makes the path on which one command is held.

    Args:
        q: Configuration at which the path starts, shape (n_q,) [rad, m].
        u: The command, shape (n_u,).
        n_base: Number of base commands, 3, 2 or 0.
        times: When the path is looked at, ascending, shape (k,) [s].
        clock: When the robot is there at the earliest, shape (k,) [s].
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
