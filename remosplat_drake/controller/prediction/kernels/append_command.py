"""A kernel that adds a command to a `History`."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.robot.actuator_response import respond


@kernel
def append_command(parameters, past, time, u, span):
    """Adds a command, and removes commands that no longer have an effect.

    Args:
        parameters: `ActuatorModel.parameters`.
        past: The arrays `sent`, `u`, `v`, `way` and `drift` of the `History`.
        time: Time at which the command was sent [s].
        u: The command, shape (n_u,) [m/s, rad/s].
        span: Time for which commands are stored [s].

    Returns:
        The same five arrays with one more row.
    """
    sent, told, v, way, drift = past
    last = len(sent) - 1
    starts, until = np.full(len(u), sent[last]), np.full((1, len(u)), time)
    gone, speed = respond(parameters, sent, told, starts, v[last], until)
    for j in range(len(u)):
        gone[0, j] += way[last, j]
    first = max(np.searchsorted(sent, time - span) - 1, 0)
    now = np.empty(last + 2 - first)
    for i in range(first, last + 1):
        now[i - first] = sent[i]
    now[-1] = time
    return (
        now,
        _with_row(told, first, u),
        _with_row(v, first, speed[0]),
        _with_row(way, first, gone[0]),
        _with_row(drift, first, drift[last]),
    )


@helper
def _with_row(rows, first, row):
    """Returns the rows from a first row on, and an additional row."""
    h = len(rows) - first
    result = np.empty((h + 1, len(row)))
    for j in range(len(row)):
        for i in range(h):
            result[i, j] = rows[first + i, j]
        result[h, j] = row[j]
    return result
