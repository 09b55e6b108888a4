"""A base that is driven in pure simulation: slow, noisy, out of calibration."""

import numpy as np

from remosplat_drake.hardware.client.base_residual import (
    WINDOWS,
    BaseSample,
    CommandedPath,
    follow_problem,
)
from remosplat_drake.hardware.wire.base import extrapolated_pose

PERIOD = 0.01
"""Time between two commands [s]."""

LIMIT = np.array([1.0, 3.0])
"""Greatest acceleration of commands [m/s^2, rad/s^2]."""

TOP = np.array([0.5, 0.87])
"""Greatest speed of commands, either way [m/s, rad/s]."""


def random_commands(random: np.random.Generator, n: int) -> np.ndarray:
    """Makes n commands from one random speed to the next, shape (n, 2)."""
    u, goal, commands = np.zeros(2), np.zeros(2), []
    for _ in range(n):
        if random.random() < PERIOD / 1.5:
            goal = TOP * random.uniform([-0.5, -1], 1, 2) * random.integers(2)
        u = u + np.clip(goal - u, -LIMIT * PERIOD, LIMIT * PERIOD)
        commands.append(u)
    return np.array(commands)


class NoisyBase:
    """Follows commands late, by a lag and a scale; its odometry is noisy."""

    def __init__(self, random: np.random.Generator, delay: float | None = None):
        """Draws what is wrong with this base.

        Args:
            random: Where chance comes from.
            delay: Delay from a command to the wheels [s]; None draws one.
        """
        self._random = random
        self._delay = random.uniform(0, 0.18) if delay is None else delay
        is_drawn = delay is None
        self._lag = random.uniform(0.02, 0.06) if is_drawn else 1e-3
        self._scale = 1 + is_drawn * random.uniform(-0.02, 0.02, 2)

    def first_alarm(
        self, commands: np.ndarray, allowed: float, stops_at: float = np.inf
    ) -> float:
        """Drives, and returns when the residual first finds a fault [s].

        Args:
            commands: The commands, shape (n, 2) [m/s, rad/s].
            allowed: Longest delay that is allowed for [s].
            stops_at: When the base stops by itself [s].

        Returns:
            The time; infinite if there is no alarm.
        """
        path, samples = CommandedPath(), []
        pose, v, late = np.zeros(3), np.zeros(2), round(self._delay / PERIOD)
        due = 0.0
        for i, u in enumerate(commands):
            t = i * PERIOD
            path.append(t, u)
            target = commands[i - late] if i >= late else np.zeros(2)
            target = target * (t < stops_at)
            v = v + (target - v) * -np.expm1(-PERIOD / self._lag)
            pose = extrapolated_pose(pose, self._scale * v, PERIOD)
            if t < due or self._random.random() < 0.02:
                continue
            due = t + 0.027
            noise = [4e-4, 4e-4, 1e-3] * self._random.normal(size=3)
            # Stamped by a busy computer.
            stamp = t + PERIOD + self._random.uniform(-0.004, 0.004)
            samples = [s for s in samples if s.stamp > t - max(WINDOWS) - 0.1]
            samples.append(BaseSample(stamp, t, pose + noise, v))
            if follow_problem(path, samples, allowed):
                return t
        return np.inf
