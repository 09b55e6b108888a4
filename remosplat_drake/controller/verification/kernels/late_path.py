"""The path of a command whose robot is late, in one compiled call."""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.verification.kernels.places import chain
from remosplat_drake.robot.actuator_response import respond


@kernel
def late_path(parameters, sent, told, time, begin, u, steps, dt, ends, n_base):
    """Computes the pieces of `StoppingPath.through`.

    Args:
        parameters: The actuators, as `ActuatorModel.parameters`.
        sent: When earlier commands were sent, ascending, shape (h,) [s].
        told: These commands, shape (h, n_u).
        time: When the command is sent [s].
        begin: When the path starts [s], and the velocities, shape (n_u,), and
            the configuration, shape (n_q,), by then.
        u: The command, shape (n_u,).
        steps: Number of ticks of its ramp, as `braking_steps` counts them.
        dt: Control period [s].
        ends: When the pieces end, from the path's start on, but for a last
            one, shape (s - 1,) [s].
        n_base: Number of base commands, 2 or 0.

    Returns:
        The configurations at which the pieces begin, shape (s, n_q), the
        velocities on them, shape (s, n_u), and the times at which they begin
        and end, shape (s,) each [s].
    """
    start, v_start, q_start = begin
    h, s, n = len(sent), len(ends) + 1, len(u)
    ramp = max(steps, 1.0)
    sends = math.ceil(ramp) + 1
    all_sent, all_told = np.empty(h + sends), np.empty((h + sends, n))
    for i in range(h + sends):
        k = i - h
        all_sent[i] = sent[i] if k < 0 else time + k * dt
        share = max(1.0 - k / ramp, 0.0)
        for j in range(n):
            all_told[i, j] = told[i, j] if k < 0 else share * u[j]
    until = np.empty((s - 1, n))
    for i in range(s - 1):
        for j in range(n):
            until[i, j] = start + ends[i]
    starts = np.full(n, start)
    way, v = respond(parameters, all_sent, all_told, starts, v_start, until)
    rates, since, times = np.empty((s, n)), np.empty(s), np.empty(s)
    for i in range(s):
        since[i] = times[i - 1] if i else 0.0
        times[i] = ends[i] if i < s - 1 else since[i] + dt
        for j in range(n):
            # What a lag has left is one last piece.
            if i == s - 1:
                gone = parameters[j, 1] * v[i - 1, j]
            else:
                gone = way[i, j] - (way[i - 1, j] if i else 0.0)
            rates[i, j] = gone / (times[i] - since[i])
    return chain(q_start, rates, times - since, n_base), rates, since, times
