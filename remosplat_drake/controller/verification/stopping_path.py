"""`StoppingPath`: the way that a command takes, down to a standstill."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.braking import braking_steps, stopping_times
from remosplat_drake.controller.verification.kernels.late_path import late_path
from remosplat_drake.controller.verification.kernels.places import places
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion import Motion

_SETTLED = 6.0
"""Time constants after which the rest of a lag is one last piece."""

_GROWTH = 1.5
"""How much longer each piece is than the one before while a lag settles."""


@dc.dataclass(frozen=True, eq=False)
class StoppingPath:
    """One tick of a command and its braking ramp, as a path.

    It is a sequence of pieces, on each of which velocities are held: the
    arm's joints move on a straight line, the base on an arc.

    A robot that obeys at once needs one piece. The ramp shrinks the whole
    command evenly, so tick and ramp follow the path on which u is simply
    held, only slower and slower. Time on the path is counted as if u were
    held. Whoever executes a smaller share of u, or brakes earlier, stays on
    this path.

    Where actuators delay and lag, each in its own way, the path is the one
    that their model follows: what is in flight, then the command, then its
    ramp, until all has settled. Time is then that of the clock.

    Attributes:
        robot: The robot, whose kinematics predict configurations.
        starts: Configurations at which the s pieces begin, shape (s, n_q)
            [rad, m].
        rates: Velocities on the pieces, shape (s, n_u) [rad/s, m/s].
        since: When the pieces begin, from 0 on, shape (s,) [s].
        times: When the path is looked at, ascending to its end, shape (k,)
            [s]; the ends of all pieces are among them.
        clock: When the robot is there at the earliest, shape (k,) [s]: what
            moves by itself is looked at then.
        peak: Greatest speeds on the path, or commanded on it, shape (n_u,)
            [rad/s, m/s].
        tube: By how much positions may be off the path, as shares of `peak`,
            shape (n_u,) [s].
    """

    robot: RobotModel
    starts: np.ndarray
    rates: np.ndarray
    since: np.ndarray
    times: np.ndarray
    clock: np.ndarray
    peak: np.ndarray
    tube: np.ndarray

    @staticmethod
    def make(
        robot: RobotModel,
        q: np.ndarray,
        u: np.ndarray,
        acceleration_limit: np.ndarray,
        dt: float,
    ) -> "StoppingPath":
        """Makes the path of a command that is obeyed at once.

        Args:
            robot: The robot, whose kinematics predict configurations.
            q: Configuration at which the path starts, shape (n_q,) [rad, m].
            u: The command, shape (n_u,) [rad/s, m/s].
            acceleration_limit: Bounds on |du/dt| of the ramp, shape (n_u,).
            dt: Control period [s].
        """
        times = stopping_times(u, acceleration_limit, dt)
        path = StoppingPath.held(robot, q, u, times)
        clock = dt * np.arange(1.0, len(times) + 1.0)
        return dc.replace(path, clock=clock)

    @staticmethod
    def held(
        robot: RobotModel, q: np.ndarray, u: np.ndarray, times: np.ndarray
    ) -> "StoppingPath":
        """Makes the path on which one command is held.

        Args:
            robot: The robot, whose kinematics predict configurations.
            q: Configuration at which the path starts, shape (n_q,) [rad, m].
            u: The command, shape (n_u,) [rad/s, m/s].
            times: When the path is looked at, ascending, shape (k,) [s].
        """
        return StoppingPath(
            robot,
            q[None],
            u[None],
            np.zeros(1),
            times,
            times,
            np.abs(u),
            np.zeros_like(u),
        )

    @staticmethod
    def through(
        robot: RobotModel,
        motion: Motion,
        u: np.ndarray,
        acceleration_limit: np.ndarray,
        dt: float,
    ) -> "StoppingPath":
        """Makes the path of a command that actuators delay and lag behind.

        Args:
            robot: The robot, whose kinematics predict configurations.
            motion: What the robot is about to do already.
            u: The command, shape (n_u,) [rad/s, m/s].
            acceleration_limit: Bounds on |du/dt| of the ramp, shape (n_u,).
            dt: Control period [s].
        """
        model = motion.model
        steps = braking_steps(u, acceleration_limit, dt)
        peak = np.maximum(motion.in_flight, np.abs(u))
        ramp = math.ceil(max(steps, 1.0)) * dt
        starts, rates, since, times = late_path(
            model.parameters,
            motion.sent,
            motion.u,
            motion.time,
            (motion.start, motion.v_start, motion.q_start),
            # A copy, since numba compiles for arrays that may be written.
            np.array(u, float),
            steps,
            dt,
            _ends(motion, peak, ramp, dt),
            robot.n_base,
        )
        peak = np.maximum(peak, np.abs(rates).max(axis=0))
        return StoppingPath(
            robot, starts, rates, since, times, times, peak, model.tube
        )

    def at(self, times: np.ndarray) -> np.ndarray:
        """Predicts configurations on the path.

        Args:
            times: Times on the path, shape (k,) [s].

        Returns:
            The configurations, shape (k, n_q) [rad, m].
        """
        return places(self.arrays, times)

    @property
    def arrays(self) -> tuple:
        """The path as kernels take it.

        They are the pieces' starts, rates and times, the number of base
        commands, and the times of looks.
        """
        n_base = self.robot.n_base
        return self.starts, self.rates, self.since, n_base, self.times

    @property
    def knots(self) -> np.ndarray:
        """Configurations where pieces begin, and the last, (s + 1, n_q)."""
        return np.concatenate([self.starts, self.at(self.times[-1:])])

    @property
    def spans(self) -> np.ndarray:
        """How long the pieces last, shape (s,) [s]."""
        return np.diff(np.append(self.since, self.times[-1]))

    def sphere_travel(self) -> np.ndarray:
        """Bounds the lengths of the spheres' ways on the path, (n,) [m]."""
        return (self.robot.jacobian_bound @ np.abs(self.rates).T) @ self.spans

    def sphere_tube(self) -> np.ndarray:
        """Bounds how far spheres may be off the path, shape (n,) [m]."""
        return self.robot.sphere_tube(self.tube, self.peak)


def _ends(
    motion: Motion, peak: np.ndarray, ramp: float, dt: float
) -> np.ndarray:
    """Returns when the pieces of a path end, from the path's start on [s].

    Args:
        motion: What the robot is about to do already.
        peak: Greatest speeds commanded, shape (n_u,) [rad/s, m/s].
        ramp: Time from the command to the end of its ramp [s].
        dt: Control period [s].
    """
    _, lag, slope, _ = motion.model.parameters.T
    told = ramp + motion.time + motion.model.delay.max() - motion.start
    ends = [dt * i for i in range(1, math.ceil(told / dt - 1e-9) + 1)]
    rest = max(_SETTLED * lag.max(), float((peak / slope).max()))
    piece, longest = dt, max(0.25 * lag.max(), 2.0 * dt)
    last = ends[-1] + rest
    while ends[-1] < last - 1e-9:
        piece = min(_GROWTH * piece, longest)
        ends.append(min(ends[-1] + piece, last))
    return np.array(ends)
