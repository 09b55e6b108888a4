"""`StoppingPath`: the way that a command takes, down to a standstill."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.braking import stopping_times
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass(frozen=True, eq=False)
class StoppingPath:
    """One tick of a command and its braking ramp, as a path.

    The ramp shrinks the whole command evenly, so tick and ramp follow the
    path on which u is simply held, only slower and slower: the arm's joints
    on a straight line, the base on one arc. Time on the path is counted as if
    u were held. Whoever executes a smaller share of u, or brakes earlier,
    stays on this path.

    Attributes:
        robot: The robot, whose kinematics predict configurations.
        q: Configuration at which the path starts, shape (n_q,) [rad, m].
        u: The command, shape (n_u,) [rad/s, m/s].
        times: Ends of the tick and of each tick of the ramp, shape (k,) [s].
    """

    robot: RobotModel
    q: np.ndarray
    u: np.ndarray
    times: np.ndarray

    @staticmethod
    def make(
        robot: RobotModel,
        q: np.ndarray,
        u: np.ndarray,
        acceleration_limit: np.ndarray,
        dt: float,
    ) -> "StoppingPath":
        """Makes the path of a command.

        Args:
            robot: The robot, whose kinematics predict configurations.
            q: Configuration at which the path starts, shape (n_q,) [rad, m].
            u: The command, shape (n_u,) [rad/s, m/s].
            acceleration_limit: Bounds on |du/dt| of the ramp, shape (n_u,).
            dt: Control period [s].
        """
        times = stopping_times(u, acceleration_limit, dt)
        return StoppingPath(robot, q, u, times)

    def at(self, times: np.ndarray) -> np.ndarray:
        """Predicts configurations on the path.

        Args:
            times: Times on the path, shape (k,) [s].

        Returns:
            The configurations, shape (k, n_q) [rad, m].
        """
        return self.robot.advance_for(self.q, self.u, times)

    @property
    def arrays(self) -> tuple:
        """The path as kernels take it: q, u, number of base commands, times."""
        return self.q, self.u, self.robot.n_base, self.times

    @property
    def end(self) -> np.ndarray:
        """Configuration at the end of the path, shape (n_q,) [rad, m]."""
        return self.robot.advance(self.q, self.u, self.times[-1])

    def sphere_travel(self) -> np.ndarray:
        """Bounds the lengths of the spheres' ways on the path, (n,) [m]."""
        return self.robot.jacobian_bound @ np.abs(self.u) * self.times[-1]
