"""`VelocityProfile`: outputs given velocities of the axes, row by row."""

import dataclasses as dc
import math

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.base.ranges import Config
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target
from remosplat_drake.task.arrival import ArrivalConfig
from remosplat_drake.task.target_sequence import TargetProgress

_ROUNDING = 1e-6
"""Rounding error of a time, relative to a period."""


@dc.dataclass(frozen=True, eq=False)
class _Playing:
    """The present motion; a deep copy is the object itself.

    Attributes:
        start: Start time of the first row [s]; NaN before the first profile.
        u: The rows, shape (k, n_u) [m/s, rad/s].
    """

    start: float
    u: np.ndarray

    def __deepcopy__(self, memo) -> "_Playing":
        return self


class VelocityProfile(LeafSystem):
    """Outputs velocities, for a control law with `VelocityTracking`.

    .. pydrake_system::

        name: VelocityProfile
        input_ports:
        - configuration
        output_ports:
        - target
        - aim

    The system outputs zero velocity before `play` and after the last row.
    `target` is the measured pose of the end effector, since a profile has no
    target pose. `aim` is that pose, with the velocities of the present period.

    Args:
        robot: The robot.
        period: Duration of a row [s].
    """

    def __init__(self, *, robot: RobotModel, period: float):
        super().__init__()
        self.set_name("targets")
        self._robot, self._period = robot, period
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        nothing = _Playing(math.nan, np.zeros((0, robot.n_u)))
        self._cell = int(self.DeclareAbstractState(Value[object](nothing)))
        self.DeclareAbstractOutputPort(
            "target", Value(RigidTransform()).Clone, self._calc_target
        )
        self.DeclareAbstractOutputPort(
            "aim", Value[object]().Clone, self._calc_aim
        )

    def play(self, context: Context, u: np.ndarray) -> None:
        """Starts a profile at the present time of the context.

        Args:
            context: The system's own context, between two steps of a
                simulation.
            u: Velocities, one row per period, shape (k, n_u) [m/s, rad/s].
        """
        value = context.get_mutable_abstract_state(self._cell)
        value.set_value(_Playing(context.get_time(), np.array(u, float)))

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress, in which the profile counts as one target.

        Args:
            context: The system's own context.
        """
        playing, row = self._playing(context), self._row(context)
        return TargetProgress(int(0 < len(playing.u) <= row), 1)

    def error(self, context: Context) -> PoseError:
        """Returns an error of zero, since a profile has no target pose.

        Args:
            context: The system's own context.
        """
        X_WE = self._X_WE(context)
        return Target(X_WE).error(X_WE)

    def _playing(self, context: Context) -> _Playing:
        return context.get_abstract_state(self._cell).get_value()

    def _row(self, context: Context) -> float:
        """Number of the present row; NaN before the first profile."""
        elapsed = context.get_time() - self._playing(context).start
        row = elapsed / self._period + _ROUNDING
        return row if math.isnan(row) else math.floor(row)

    def _X_WE(self, context: Context) -> np.ndarray:
        q = self._configuration_input.Eval(context)
        return self._robot.end_effector_poses(q)[0]

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(RigidTransform(self._X_WE(context)))

    def _calc_aim(self, context: Context, output: AbstractValue):
        playing, row = self._playing(context), self._row(context)
        u = np.zeros(self._robot.n_u)
        if 0 <= row < len(playing.u):
            u = playing.u[int(row)]
        output.set_value(Aim((Target.of(self._X_WE(context)),), u))


@dc.dataclass
class ProfileMaker(Config):
    """Settings that make a `VelocityProfile`; see `TargetsMaker`."""

    def make(
        self, robot: RobotModel, arrival: ArrivalConfig, period: float
    ) -> VelocityProfile:
        """Makes the system; see `TargetsMaker`."""
        return VelocityProfile(robot=robot, period=period)
