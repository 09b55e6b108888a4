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
        robot: Predicts configurations.
        q: Configuration at which it starts, shape (n_q,).
        u: Command, shape (n_u,).
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
        """The path of a command.

        Args:
            robot: Predicts configurations.
            q: Configuration at which it starts, shape (n_q,).
            u: Command, shape (n_u,).
            acceleration_limit: Bounds on |du/dt| of the ramp, shape (n_u,).
            dt: Control period [s].
        """
        times = stopping_times(u, acceleration_limit, dt)
        return StoppingPath(robot, q, u, times)

    def at(self, times: np.ndarray) -> np.ndarray:
        """Configurations at times on the path, shape (k, n_q)."""
        return self.robot.advance_for(self.q, self.u, times)

    @property
    def arrays(self) -> tuple:
        """What kernels know of it: q, u, number of base commands, times."""
        return self.q, self.u, self.robot.n_base, self.times

    @property
    def end(self) -> np.ndarray:
        """Configuration at its end, shape (n_q,)."""
        return self.robot.advance(self.q, self.u, self.times[-1])

    def sphere_travel(self) -> np.ndarray:
        """Bounds on the lengths of the spheres' ways, shape (n,) [m]."""
        return self.robot.jacobian_bound @ np.abs(self.u) * self.times[-1]
