"""Measures how fast unreported stops of a base are detected, and false alarms.

    python -m apps.studies.base_stops --hours 10

Bases are driven at random in pure simulation, a minute each. Each follows its
commands with its own delay, lag and scale; its odometry is noisy, is stamped by
a busy computer and is lost at times. The detector is the residual that stops
the robot.
"""

import argparse
import dataclasses as dc

import numpy as np

from remosplat_drake.hardware.client.base_residual import (
    WINDOWS,
    CommandedPath,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.base import (
    base_axes,
    base_velocity,
    extrapolated_pose,
)
from remosplat_drake.robot.planar_pose import matrix

PERIOD = 0.01
"""Time between two commands [s]."""

STATUS_PERIOD = 3
"""Number of command periods between two odometry messages."""

SPEED_PERIOD = 10
"""Number of command periods between two measurements of the speed."""

LIMIT = np.array([1.0, 3.0])
"""Commands accelerate at most this much [m/s^2, rad/s^2]."""

NOISE = np.array([4e-4, 4e-4, 1e-3])
"""Standard deviations of the odometry from one message to the next [m, rad]."""

JITTER = 0.004
"""A stamp is early or late by at most this time [s]."""

LOSS = 0.02
"""Fraction of the odometry messages that are lost."""

SESSION = 60.0
"""Time for which a base is driven [s]."""

SPEEDS = (0.05, 0.1, 0.2, 0.5)
"""Speeds at which bases stop [m/s]."""


@dc.dataclass(frozen=True)
class Base:
    """Faults of a base.

    Attributes:
        delay: Time from a command to the wheels [s].
        lag: Time constant of the wheels [s].
        scale: Ratios of the speeds to the commanded ones, shape (2,).
    """

    delay: float
    lag: float
    scale: np.ndarray

    @staticmethod
    def drawn(random: np.random.Generator) -> "Base":
        """Draws a base whose delay and lag together are less than 0.25 s."""
        return Base(
            random.uniform(0.0, 0.15),
            random.uniform(0.02, 0.08),
            1 + random.uniform(-0.02, 0.02, 2),
        )


@dc.dataclass(frozen=True)
class Drive:
    """A drive and its odometry.

    Attributes:
        path: The commands.
        stamp: Stamps of the odometry, shape (k,) [s].
        pose: x, y, yaw by it, shape (k, 3) [m, m, rad].
        speed: Speeds that it reports, measured ten times a second, shape (k, 2)
            [m/s, rad/s].
    """

    path: CommandedPath
    stamp: np.ndarray
    pose: np.ndarray
    speed: np.ndarray

    def first_alarm(self, delay: float) -> float:
        """Returns the time at which the residual detects a fault [s], or inf.

        Args:
            delay: Longest delay from a command to its effect [s].
        """
        alarm = np.inf
        for window in WINDOWS:
            first = np.searchsorted(self.stamp, self.stamp - window, "right")
            X_WA = matrix(self.pose[first])
            p = np.einsum(
                "nji,nj->ni",
                X_WA[:, :2, :2],
                self.pose[:, :2] - self.pose[first, :2],
            )
            turn = self.pose[:, 2] - self.pose[first, 2]
            moved = np.column_stack([p, (turn + np.pi) % (2 * np.pi) - np.pi])
            _, excess = self.path.arcs.residuals(
                self.stamp[first], self.stamp, moved, delay
            )
            found = self.stamp[~(excess <= 1.0)]
            alarm = min(alarm, found.min(initial=np.inf))
        return float(alarm)


def driven(
    random: np.random.Generator,
    base: Base,
    commands: np.ndarray,
    stops_at: float = np.inf,
) -> Drive:
    """Drives a base.

    Args:
        random: Source of randomness.
        base: Faults of the base.
        commands: The commands, shape (n, 2) [m/s, rad/s].
        stops_at: Time at which it stops by itself [s].
    """
    path = CommandedPath()
    pose, v, late = np.zeros(3), np.zeros(2), round(base.delay / PERIOD)
    share = -np.expm1(-PERIOD / base.lag)
    stamps, poses, speeds, told = [], [], [], v
    for i, u in enumerate(commands):
        t = i * PERIOD
        path.append(t, base_velocity(u))
        if t < stops_at:
            target = commands[i - late] if i >= late else np.zeros(2)
            v = v + share * (target - v)
        else:
            v = np.zeros(2)
        pose = extrapolated_pose(pose, base_velocity(base.scale * v), PERIOD)
        if i % SPEED_PERIOD == 0:
            told = v
        if i % STATUS_PERIOD == 0 and random.random() >= LOSS:
            stamps.append(t + PERIOD + random.uniform(-JITTER, JITTER))
            poses.append(pose + NOISE * random.normal(size=3))
            speeds.append(base_velocity(told))
    return Drive(path, np.array(stamps), np.array(poses), np.array(speeds))


def random_commands(random: np.random.Generator, n: int) -> np.ndarray:
    """Makes n commands from one random speed to the next, shape (n, 2)."""
    config = HardwareConfig()
    lower, upper = (bound[base_axes(2)] for bound in config.base_bounds)
    u, goal = np.zeros(2), np.zeros(2)
    commands = np.zeros((n, 2))
    for i in range(n):
        if random.random() < PERIOD / 1.5:
            goal = random.uniform(lower, upper) * random.integers(2, size=2)
        u = u + np.clip(goal - u, -LIMIT * PERIOD, LIMIT * PERIOD)
        commands[i] = u
    return commands


def false_alarms(random: np.random.Generator, hours: float) -> tuple[int, int]:
    """Counts the drives with a false alarm, and all drives."""
    delay, n = HardwareConfig.base_delay, round(SESSION / PERIOD)
    count = max(1, round(3600 * hours / SESSION))
    alarms = 0
    for _ in range(count):
        drive = driven(random, Base.drawn(random), random_commands(random, n))
        alarms += np.isfinite(drive.first_alarm(delay))
    return alarms, count


def time_to_alarm(
    random: np.random.Generator, speed: float, base: Base
) -> float:
    """Returns the time from a stop to its detection by the residual [s].

    Args:
        random: Source of randomness.
        speed: Speed at which the base stops [m/s].
        base: Faults of the base.
    """
    commands = np.tile([speed, 0.0], (600, 1))
    commands[:50] *= np.linspace(0, 1, 50)[:, None]
    stops_at = random.uniform(3.0, 4.0)
    drive = driven(random, base, commands, stops_at)
    return drive.first_alarm(HardwareConfig.base_delay) - stops_at


def main() -> None:
    """Prints both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=10.0)
    parser.add_argument("--stops", type=int, default=50, help="a speed")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    for speed in SPEEDS:
        times = [
            time_to_alarm(random, speed, Base.drawn(random))
            for _ in range(arguments.stops)
        ]
        print(
            f"stopped at {speed:g} m/s: found after {np.median(times):.2f} s,"
            f" at most {max(times):.2f} s",
            flush=True,
        )
    alarms, count = false_alarms(random, arguments.hours)
    print(f"{arguments.hours:g} h, {count} drives: {alarms} false alarms")


if __name__ == "__main__":
    main()
