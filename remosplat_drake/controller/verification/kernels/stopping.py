"""Computes the path of a command: a tick and its braking ramp, to standstill.

For a robot without delay, the path has one piece. The ramp scales the whole
command, so during tick and ramp the robot follows the path of a held command u,
at decreasing speed. A time on the path is the time at which a robot with a held
u would be at this place. A robot that executes a smaller fraction of u, or that
brakes earlier, remains on this path. The path ends at the last place at which
the robot can stop, which is where it stops if its station receives no further
command.

If the actuators have delays and lags, the path is that of their model. It
contains the motion by commands in flight, by the command, and by the command's
ramp, until all axes have settled. Time on this path is clock time.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.verification.kernels.places import (
    PATH,
    PathArrays,
    chain,
    held,
)
from remosplat_drake.robot.actuator_response import respond
from remosplat_drake.robot.braking import (
    braking_steps,
    stopping_times,
)

_SETTLED = 6.0
"""Number of time constants of a lag that are divided into pieces. The rest of
the lag is a single last piece."""

_GROWTH = 1.5
"""Ratio of the durations of consecutive pieces while a lag settles."""


@kernel(returns=PATH)
def stopping_path(robot, motion, q, u, dt, spare) -> PathArrays:
    """Makes the path of a command and its ramp.

    Args:
        robot: The `RobotArrays`.
        motion: The `MotionArrays`: the motion that commands in flight cause.
        q: Configuration at which the path starts, shape (n_q,) [rad, m].
        u: The command, shape (n_u,).
        dt: Duration of a tick [s].
        spare: Time for which a station holds a command after the end of its
            tick [s]. The tube of a robot with delay already includes it.
    """
    limit = robot.acceleration_limit
    if motion.is_late:
        return _late_path(motion, q, u, limit, dt, robot.n_base)
    times = stopping_times(u, limit, dt, spare)
    clock = dt * np.arange(1.0, len(times) + 1.0)
    clock[-1] = clock[-2] + spare
    return held(q, u, robot.n_base, times, clock)


@helper
def in_flight(motion):
    """Returns the greatest speeds of commands that are in flight, (n_u,).

    Args:
        motion: The `MotionArrays` of a robot with delay.
    """
    longest = 0.0
    for j in range(len(motion.parameters)):
        longest = max(longest, motion.parameters[j, 0])
    first = max(np.searchsorted(motion.sent, motion.start - longest) - 1, 0)
    speed = np.abs(motion.v_start)
    for i in range(first, len(motion.sent)):
        for j in range(len(speed)):
            speed[j] = max(speed[j], abs(motion.u[i, j]))
    return speed


@helper
def _late_path(motion, q, u, limit, dt, n_base):
    """Returns the path of a robot with delay, by its actuator model."""
    steps = max(braking_steps(u, limit, dt), 1.0)
    h, n, sends = len(motion.sent), len(u), math.ceil(steps) + 1
    sent, told = np.empty(h + sends), np.empty((h + sends, n))
    for i in range(h + sends):
        k = i - h
        sent[i] = motion.sent[i] if k < 0 else motion.time + k * dt
        share = max(1.0 - k / steps, 0.0)
        for j in range(n):
            told[i, j] = motion.u[i, j] if k < 0 else share * u[j]
    peak = in_flight(motion)
    for j in range(n):
        peak[j] = max(peak[j], abs(u[j]))
    ends = _ends(motion, peak, math.ceil(steps) * dt, dt)
    s = len(ends) + 1
    until = np.empty((s - 1, n))
    for i in range(s - 1):
        for j in range(n):
            until[i, j] = motion.start + ends[i]
    way, v = respond(
        motion.parameters,
        sent,
        told,
        np.full(n, motion.start),
        motion.v_start,
        until,
    )
    rates, since, times = np.empty((s, n)), np.empty(s), np.empty(s)
    for i in range(s):
        since[i] = times[i - 1] if i else 0.0
        times[i] = ends[i] if i < s - 1 else since[i] + dt
        for j in range(n):
            # The rest of a lag is a single last piece.
            if i == s - 1:
                gone = motion.parameters[j, 1] * v[i - 1, j]
            else:
                gone = way[i, j] - (way[i - 1, j] if i else 0.0)
            rates[i, j] = gone / (times[i] - since[i])
            peak[j] = max(peak[j], abs(rates[i, j]))
    starts = chain(q, rates, times - since, n_base)
    tube = motion.tube.copy()
    return PathArrays(starts, rates, since, n_base, times, times, peak, tube)


@helper
def _ends(motion, peak, ramp, dt):
    """Returns the end times of all pieces of a path except the last [s].

    Args:
        motion: The `MotionArrays`.
        peak: Greatest commanded speed of each axis, shape (n_u,).
        ramp: Time from the command to the end of its ramp [s].
        dt: Control period [s].
    """
    delay, lag, rest = 0.0, 0.0, 0.0
    for j in range(len(peak)):
        delay = max(delay, motion.parameters[j, 0])
        lag = max(lag, motion.parameters[j, 1])
        rest = max(rest, peak[j] / motion.parameters[j, 2])
    told = ramp + motion.time + delay - motion.start
    ends = [dt * i for i in range(1, math.ceil(told / dt - 1e-9) + 1)]
    piece, longest = dt, max(0.25 * lag, 2.0 * dt)
    last = ends[-1] + max(_SETTLED * lag, rest)
    while ends[-1] < last - 1e-9:
        piece = min(_GROWTH * piece, longest)
        ends.append(min(ends[-1] + piece, last))
    return np.array(ends)
