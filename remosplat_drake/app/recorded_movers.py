"""`RecordedMovers`: replays the moving obstacles of a recorded run."""

import dataclasses as dc
from pathlib import Path
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.ranges import Config
from remosplat_drake.recording.trajectory import Trajectory, load_trajectory
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.mover import Mover
from remosplat_drake.station.robot_movers import (
    MOST_ACCELERATION,
    link_movers,
    link_shapes,
)


@dc.dataclass
class RecordedMovers(Config):
    """The moving obstacles of a recorded run, or the robot of that run.

    After the end of the recording, the obstacles are at rest.
    """

    # The `trajectory.npz` of a run, relative to this file's folder.
    file: Annotated[str, Len(1)] = "trajectory.npz"
    # Name or file of the recorded run's robot, whose links become the movers.
    # Empty: replay the movers of the run.
    robot: str = ""
    # Name under which messages and pages show the recorded robot.
    name: str = "recorded robot"
    # Speed limit that our robot assumes for all points of the recorded robot's
    # links [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=100)] = 1.5
    # Acceleration limit that our robot assumes for all points of the recorded
    # robot's links [m/s^2].
    max_acceleration: Annotated[float, Interval(gt=0, le=1000)] = (
        MOST_ACCELERATION
    )

    def make(self, folder: Path) -> "RecordedTrack | RecordedRobot":
        """Reads the recording.

        Args:
            folder: The folder that the file's name refers to.

        Raises:
            RemoSplatError: The file is not a recording, contains no movers, or
                belongs to another robot.
        """
        path = folder / self.file
        trajectory = load_trajectory(path)
        if not len(trajectory):
            raise FileError(path, "has no ticks")
        if not self.robot:
            if not trajectory.movers:
                raise FileError(
                    path,
                    "contains no movers; set `robot` to replay the run's robot",
                )
            return RecordedTrack(trajectory)
        robot = load_robot(self.robot)
        n = trajectory.q.shape[1]
        if robot.n_q != n:
            problem = (
                f"was recorded with a robot of {n} positions, but "
                f"`robot` has {robot.n_q}"
            )
            raise FileError(path, problem)
        return RecordedRobot(self, robot, trajectory)


def _tick(trajectory: Trajectory, time: float) -> tuple[int, float]:
    """Returns the index of the tick at a time, and the time since then [s]."""
    since = trajectory.time - trajectory.time[0]
    k = int(np.searchsorted(since, time + 1e-9, "right")) - 1
    k = min(max(k, 0), len(trajectory) - 1)
    return k, time - float(since[k])


class RecordedTrack:
    """Replays the movers around the robot of a recorded run.

    Args:
        trajectory: The run.
    """

    def __init__(self, trajectory: Trajectory):
        self._trajectory = trajectory

    def movers(self, time: float) -> list[Mover]:
        """Returns the movers at a time of the recorded run.

        Args:
            time: Time since the run began [s].
        """
        k, late = _tick(self._trajectory, time)
        movers = self._trajectory.movers[k]
        if k == len(self._trajectory) - 1:
            none = np.zeros(3)
            return [dc.replace(m, v_WM=none, w_WM=none) for m in movers]
        return list(movers.predicted(movers.stamp + late))


class RecordedRobot:
    """Replays the links of a recorded run's robot as movers.

    Args:
        config: The robot's display name, and the assumed bounds of its motion.
        robot: The robot.
        trajectory: The run.
    """

    def __init__(
        self, config: RecordedMovers, robot: RobotModel, trajectory: Trajectory
    ):
        self._config, self._robot = config, robot
        self._trajectory = trajectory
        self._shapes = link_shapes(robot)

    def movers(self, time: float) -> list[Mover]:
        """Returns the robot's links at a time of the recorded run.

        Args:
            time: Time since the run began [s].
        """
        k, late = _tick(self._trajectory, time)
        q, u = self._trajectory.q[k], self._trajectory.u[k]
        if k == len(self._trajectory) - 1:
            q, u, late = self._trajectory.q[-1], np.zeros_like(u), 0.0
        if late > 0.0:
            q = self._robot.advance(q, u, late)
        return link_movers(
            self._robot,
            self._shapes,
            q,
            u,
            name=self._config.name,
            max_speed=self._config.max_speed,
            max_acceleration=self._config.max_acceleration,
        )
