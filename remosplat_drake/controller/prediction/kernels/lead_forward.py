"""A kernel that computes the motion that commands in flight cause."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.verification.kernels.places import chain
from remosplat_drake.robot.actuator_response import respond

LONG_AGO = -1e12
"""A time before all other times [s]."""

PIECES = 8
"""Number of arcs that approximate a base's predicted motion."""


@kernel
def lead_forward(parameters, past, q, stamp, now, n_base):
    """Computes the motion that commands already sent cause after a measurement.

    Args:
        parameters: `ActuatorModel.parameters`.
        past: The arrays `sent`, `u`, `v` and `way` of the `History`.
        q: Measured configuration, shape (n_q,) [m, rad].
        stamp: Time at which each axis was measured, shape (n_u,) [s].
        now: Time at which the next command is sent [s].
        n_base: Number of base commands.

    Returns:
        The attributes `start`, `q_start`, `v_start`, `q_planned`, `v_measured`
        and `way_measured` of a `Motion`.
    """
    sent, told, v_past, way_past = past
    n = len(stamp)
    start = np.inf
    for j in range(n):
        start = min(start, now + parameters[j, 0])
    began, v_began, way_began = np.empty(n), np.empty(n), np.empty(n)
    until = np.empty((2 * PIECES + 1, n))
    for j in range(n):
        measured = min(max(stamp[j], LONG_AGO), now)
        row = max(np.searchsorted(sent, measured, side="right") - 1, 0)
        began[j], v_began[j] = sent[row], v_past[row, j]
        way_began[j] = way_past[row, j]
        ends = now + parameters[j, 0]
        for k in range(2 * PIECES + 1):
            time = measured + k / PIECES * (start - measured)
            if k > PIECES:
                time = start + (k - PIECES) / PIECES * (ends - start)
            until[k, j] = max(time, began[j])
    way, v = respond(parameters, sent, told, began, v_began, until)
    ways = np.empty((PIECES, n))
    rest = np.empty((PIECES + 1, n))
    for j in range(n):
        for k in range(PIECES):
            ways[k, j] = way[k + 1, j] - way[k, j]
            rest[k, j] = way[PIECES + k + 1, j] - way[PIECES + k, j]
        rest[PIECES, j] = parameters[j, 1] * v[2 * PIECES, j]
        way_began[j] += way[0, j]
    q_start = led(q, ways, n_base)
    q_planned = led(q_start, rest, n_base)
    return start, q_start, v[PIECES], q_planned, v[0], way_began


@helper
def led(q, ways, n_base):
    """Moves a configuration by s short displacements.

    Args:
        q: The configuration, shape (n_q,) [rad, m].
        ways: The displacements of all axes, shape (s, n_u) [rad, m].
        n_base: Number of base commands.
    """
    if not ways.any():
        return q
    # Each displacement takes one unit of time. The result is the start of an
    # additional piece of the path after the last displacement.
    return chain(q, ways, np.ones(len(ways) + 1), n_base)[-1]
