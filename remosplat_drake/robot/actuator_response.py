"""Kernels of the actuator models: the exact motion between two commands."""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import reals, several


@kernel(linked=True)
def step(v, target, dt, time_constant, acceleration, dead_band):
    """Advances one axis while one command is in effect, exactly.

    Args:
        v: Velocity of the axis [rad/s, m/s].
        target: The command in effect [rad/s, m/s].
        dt: Duration of the step [s].
        time_constant: Time constant of a first-order lag [s]; 0 for none.
        acceleration: Bound on the rate of change of the velocity, used if there
            is no lag; infinite for none [rad/s^2, m/s^2].
        dead_band: Least command that moves the axis [rad/s, m/s].

    Returns:
        The velocity at the end [rad/s, m/s], and the distance travelled [rad,
        m].
    """
    if abs(target) < dead_band:
        target = 0.0
    if time_constant > 0.0:
        left = math.exp(-dt / time_constant)
        gap = v - target
        way = target * dt + gap * time_constant * (1.0 - left)
        return target + gap * left, way
    if acceleration == math.inf:
        return target, target * dt
    ramp = abs(target - v) / acceleration
    if ramp <= dt:
        return target, 0.5 * (v + target) * ramp + target * (dt - ramp)
    after = v + math.copysign(acceleration * dt, target - v)
    return after, 0.5 * (v + after) * dt


@kernel(returns=several(reals(2), reals(2)))
def respond(parameters, sent, u, start, v, until):
    """Computes the motion of all axes; see `ActuatorModel.response`."""
    k, n = until.shape
    ways, velocities = np.empty((k, n)), np.empty((k, n))
    for j in range(n):
        delay, lag, ramp, dead_band = parameters[j]
        time, speed, way = start[j], v[j], 0.0
        i = np.searchsorted(sent, time - delay, side="right") - 1
        for row in range(k):
            while time < until[row, j]:
                target = u[i, j] if i >= 0 else 0.0
                end = until[row, j]
                follows = i + 1 < len(sent) and sent[i + 1] + delay <= end
                if follows:
                    end = max(sent[i + 1] + delay, time)
                speed, x = step(speed, target, end - time, lag, ramp, dead_band)
                way += x
                time = end
                if follows:
                    i += 1
            ways[row, j], velocities[row, j] = way, speed
    return ways, velocities
