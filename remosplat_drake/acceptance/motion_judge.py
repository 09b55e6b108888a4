"""Did the robot stop, and did it stay? Judged by its true motion."""

import dataclasses as dc
from pathlib import Path

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField

STILL = 2e-3
"""A robot that is slower stands [m/s, rad/s]."""

CREEP = 1e-3
"""A robot that stands may settle by so much [m]."""

_DWELL = 5
"""Samples for which it must be slow to count as standing."""


@dc.dataclass(frozen=True)
class StopQuality:
    """How a robot stopped.

    Attributes:
        time_to_zero: Until it stands [s]; NaN if it never does.
        moved_after: How far any of its spheres got from there [m].
    """

    time_to_zero: float
    moved_after: float

    @property
    def stays(self) -> bool:
        """Whether it has not moved any more."""
        return self.moved_after < CREEP


@dc.dataclass(frozen=True, eq=False)
class TrueRun:
    """What `remosplat hardware-sim --record` wrote.

    Attributes:
        time: Wall clock of each sample, shape (n,) [s].
        q: Configurations, shape (n, 10).
        u: Velocities, shape (n, 9).
    """

    time: np.ndarray
    q: np.ndarray
    u: np.ndarray

    @staticmethod
    def read(path: Path) -> "TrueRun":
        """Reads a record."""
        with np.load(path) as archive:
            return TrueRun(1e-6 * archive["utime"], archive["q"], archive["u"])

    def until(self, time: float) -> "TrueRun":
        """The samples before a time of the wall clock [s]."""
        before = self.time < time
        return TrueRun(self.time[before], self.q[before], self.u[before])

    def since(self, time: float) -> "TrueRun":
        """The samples from a time of the wall clock on [s]."""
        after = self.time >= time
        return TrueRun(self.time[after], self.q[after], self.u[after])


def first_standstill(run: TrueRun, since: float) -> int | None:
    """The first sample after a time from which the robot stands a while.

    Args:
        run: The motion.
        since: Wall clock [s].
    """
    still = np.abs(run.u).max(axis=1) < STILL
    start = int(np.searchsorted(run.time, since))
    for i in range(start, len(still) - _DWELL + 1):
        if still[i : i + _DWELL].all():
            return i
    return None


def judge_stop(run: TrueRun, since: float, robot: RobotModel) -> StopQuality:
    """How the robot stopped after a time, and whether it stayed.

    Args:
        run: The motion.
        since: Wall clock at which something went wrong [s].
        robot: Whose spheres are looked at.
    """
    i = first_standstill(run, since)
    if i is None:
        return StopQuality(np.nan, np.nan)
    moved = distance_moved(run.since(run.time[i]), robot)
    return StopQuality(float(run.time[i] - since), moved)


def distance_moved(run: TrueRun, robot: RobotModel) -> float:
    """How far any sphere got from where it was at first [m].

    Args:
        run: The motion; none is no motion.
        robot: Whose spheres are looked at.
    """
    p_WS = [robot.spheres_at(q).p_WS for q in run.q]
    return max(
        (float(np.linalg.norm(p - p_WS[0], axis=1).max()) for p in p_WS),
        default=0.0,
    )


def true_clearance(
    run: TrueRun, robot: RobotModel, truth: DistanceField
) -> float:
    """The smallest true distance from the scene on the way [m].

    Args:
        run: The motion.
        robot: Whose spheres are looked at.
        truth: The scene.
    """
    moving = np.abs(run.u).max(axis=1) >= STILL
    return min(
        truth.clearances(robot.spheres_at(q)).minimum()
        for q in [run.q[0], *run.q[moving], run.q[-1]]
    )
