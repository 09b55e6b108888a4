"""Judges from a robot's true motion whether it stopped and stayed at rest."""

import dataclasses as dc
from pathlib import Path

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField

STILL = 2e-3
"""A robot counts as at rest below this speed [m/s, rad/s]."""

CREEP = 1e-3
"""A robot that moves by less than this distance counts as at rest [m]."""

_DWELL = 5
"""A robot is at rest after this many consecutive slow samples."""


@dc.dataclass(frozen=True)
class StopQuality:
    """Duration of a robot's stop, and its motion afterwards.

    Attributes:
        time_to_zero: Time until the robot is at rest [s]; NaN if it does not
            come to rest.
        moved_after: Largest distance that any of the robot's spheres moved
            after the robot had stopped [m].
    """

    time_to_zero: float
    moved_after: float

    @property
    def stays(self) -> bool:
        """Whether the robot stayed within `CREEP` of its standstill."""
        return self.moved_after < CREEP


@dc.dataclass(frozen=True, eq=False)
class TrueRun:
    """The true motion of a robot, from `remosplat hardware-sim --record`.

    Attributes:
        time: Wall-clock time of each sample, shape (n,) [s].
        q: Configuration at each sample, shape (n, 10).
        u: Velocity at each sample, shape (n, 9).
    """

    time: np.ndarray
    q: np.ndarray
    u: np.ndarray

    @staticmethod
    def read(path: Path) -> "TrueRun":
        """Reads a record of the true motion."""
        with np.load(path) as archive:
            return TrueRun(1e-6 * archive["utime"], archive["q"], archive["u"])

    def until(self, time: float) -> "TrueRun":
        """Returns the samples before a wall-clock time [s]."""
        before = self.time < time
        return TrueRun(self.time[before], self.q[before], self.u[before])

    def since(self, time: float) -> "TrueRun":
        """Returns the samples from a wall-clock time on [s]."""
        after = self.time >= time
        return TrueRun(self.time[after], self.q[after], self.u[after])


def first_standstill(run: TrueRun, since: float) -> int | None:
    """Finds the first sample after which the robot is at rest for a while.

    Args:
        run: True motion of the robot.
        since: Wall-clock time at which the search begins [s].

    Returns:
        The sample's index; None if the robot never comes to rest.
    """
    still = np.abs(run.u).max(axis=1) < STILL
    start = int(np.searchsorted(run.time, since))
    for i in range(start, len(still) - _DWELL + 1):
        if still[i : i + _DWELL].all():
            return i
    return None


def judge_stop(run: TrueRun, since: float, robot: RobotModel) -> StopQuality:
    """Measures the time of a stop, and the motion after it.

    Args:
        run: True motion of the robot.
        since: Wall-clock time of the fault [s].
        robot: The robot, whose spheres represent its volume.
    """
    i = first_standstill(run, since)
    if i is None:
        return StopQuality(np.nan, np.nan)
    moved = distance_moved(run.since(run.time[i]), robot)
    return StopQuality(float(run.time[i] - since), moved)


def distance_moved(run: TrueRun, robot: RobotModel) -> float:
    """Returns the largest distance of any sphere from its first position [m].

    Args:
        run: True motion of the robot; without samples the distance is 0.
        robot: The robot, whose spheres represent its volume.
    """
    p_WS = [robot.spheres_at(q).p_WS for q in run.q]
    return max(
        (float(np.linalg.norm(p - p_WS[0], axis=1).max()) for p in p_WS),
        default=0.0,
    )


def true_clearance(
    run: TrueRun, robot: RobotModel, truth: DistanceField
) -> float:
    """Returns the smallest true distance from the scene during a run [m].

    Args:
        run: True motion of the robot.
        robot: The robot, whose spheres represent its volume.
        truth: Distances to the true scene.
    """
    moving = np.abs(run.u).max(axis=1) >= STILL
    return min(
        truth.clearances(robot.spheres_at(q)).minimum()
        for q in [run.q[0], *run.q[moving], run.q[-1]]
    )
