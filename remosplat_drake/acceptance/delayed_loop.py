"""Simulates the control loop of a robot with delays and lags.

Tick, prediction and verification are the same as in real runs. Only the robot
and the network are replaced by a model of the actuators, in simulated time. So
a case takes seconds, while a campaign with real processes takes minutes.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.predict import (
    modelled_way,
    predict,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.robot.actuators import ActuatorModel
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import Motion

_STEPS = 5
"""The robot is simulated in this many steps per tick."""

_REACHED = 0.01
"""The target counts as reached within this distance [m]."""


@dc.dataclass(frozen=True, eq=False)
class DelayedRun:
    """The result of `run_delayed`.

    Attributes:
        clearance: Smallest true clearance [m].
        time: Time until the target was reached [s]; infinite if it was not
            reached.
        distance: Distance from the target at the end [m].
        share: Largest ratio of the prediction's residual to its bound; NaN if
            no prediction was made.
        seconds: Wall-clock time of each tick, shape (n,) [s].
    """

    clearance: float
    time: float
    distance: float
    share: float
    seconds: np.ndarray


class DelayedRobot:
    """A robot whose motion follows a model of its actuators.

    Attributes:
        q: The true configurations so far, one per step, (n_q,) [m, rad].
        times: Times of the configurations [s].
        v: The true velocities at these times, each of shape (n_u,) [m/s,
            rad/s].
    """

    def __init__(
        self,
        robot: RobotModel,
        model: ActuatorModel,
        q0: np.ndarray,
        status_delay: np.ndarray,
    ):
        """Starts at rest.

        Args:
            robot: The robot.
            model: The model of its actuators.
            q0: Configuration to start from, shape (n_q,) [m, rad].
            status_delay: Age of each axis' state when it is received, shape
                (n_u,) [s].
        """
        self.robot, self.model = robot, model
        self.status_delay = status_delay
        self.q, self.times = [np.array(q0)], [0.0]
        self.v = [np.zeros(robot.n_u)]
        self._history = History.at_rest(robot.n_u)

    def move(self, u: np.ndarray, dt: float) -> None:
        """Sends a command [m/s, rad/s], and simulates a tick."""
        now = self.times[-1]
        self._history = self._history.with_command(self.model, now, u)
        until = now + dt * np.arange(1, _STEPS + 1)[:, None] / _STEPS
        ways, v = self.model.response(
            self._history.sent,
            self._history.u,
            np.full(self.robot.n_u, now),
            self.v[-1],
            np.tile(until, self.robot.n_u),
        )
        for way, speed, time in zip(
            np.diff(ways, axis=0, prepend=0.0), v, until[:, 0], strict=True
        ):
            self.q.append(self.robot.advance(self.q[-1], way, 1.0))
            self.v.append(speed)
            self.times.append(float(time))

    def heard(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns the latest measured q and u, and the stamp of each axis."""
        stamp = np.maximum(self.times[-1] - self.status_delay, 0.0)
        row = np.searchsorted(self.times, stamp - 1e-9)
        n_base = self.robot.n_base
        q = self.q[row[-1]].copy()
        if n_base:
            q[:3] = self.q[row[0]][:3]
        v = np.array([self.v[i][j] for j, i in enumerate(row)])
        return q, v, np.array(self.times)[row]


def run_delayed(
    law: ReactiveLaw,
    robot: DelayedRobot,
    field: DistanceField,
    X_WT: np.ndarray,
    model: ActuatorModel | None,
    seconds: float = 10.0,
) -> DelayedRun:
    """Simulates a robot with actuator delays that moves to a target.

    Args:
        law: The control law.
        robot: The robot, at its initial configuration.
        field: The map, which is also the true scene.
        X_WT: Pose of the target T in W, shape (4, 4).
        model: The controller's model of the actuators. With None, the
            controller only extrapolates the base's pose by its measured
            velocity.
        seconds: Longest simulated time [s].
    """
    known = History.at_rest(law.robot.n_u)
    u = np.zeros(law.robot.n_u)
    least, arrived, share, spent = math.inf, math.inf, math.nan, []
    for k in range(round(seconds / law.dt)):
        q, v, stamp = robot.heard()
        motion = None
        if model is None:
            q_plan = _extrapolated(law.robot, q, v, robot.times[-1] - stamp)
        else:
            way = modelled_way(model, known, stamp)
            known = known.with_measurement(q, way, law.robot.n_base)
            motion = predict(law.robot, model, known, q, stamp, robot.times[-1])
            q_plan = motion.q_planned
            share = max(_share(motion), 0.0 if math.isnan(share) else share)
        state = law.robot.state(q_plan)
        found = field.clearances(state.spheres, law.collision.influence)
        report = run_tick(
            law, k * law.dt, q_plan, X_WT, found, field, u, motion=motion
        )
        spent.append(sum(report.timings.values()))
        u = report.command
        if model is not None:
            known = known.with_command(model, robot.times[-1], u)
        robot.move(u, law.dt)
        for true in robot.q[-_STEPS:]:
            spheres = law.robot.spheres_at(true)
            least = min(least, field.clearances(spheres, 0.3).minimum())
        X_WE = law.robot.end_effector_pose(robot.q[-1])
        distance = pose_error(X_WE, X_WT).distance
        if distance < _REACHED and not np.abs(robot.v[-1]).max() > 0.05:
            arrived = robot.times[-1]
            break
    return DelayedRun(least, arrived, distance, share, np.array(spent))


def _extrapolated(
    robot: RobotModel, q: np.ndarray, v: np.ndarray, age: np.ndarray
) -> np.ndarray:
    way = np.zeros(robot.n_u)
    way[: robot.n_base] = (v * age)[: robot.n_base]
    return robot.advance(q, way, 1.0)


def _share(motion: Motion) -> float:
    return float((motion.residual / np.maximum(motion.bound, 1e-6)).max())
