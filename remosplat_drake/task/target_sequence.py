"""`TargetSequence`: hands out target poses, one after the other."""

import dataclasses as dc
from collections.abc import Sequence

from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.robot.pose_error import PoseError, pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived


@dc.dataclass(frozen=True)
class TargetProgress:
    """How far along a sequence of targets the robot is; copying returns itself.

    Attributes:
        index: Index of the present target; `count` when all are reached.
        count: Number of targets in the sequence.
    """

    index: int
    count: int

    def __deepcopy__(self, memo) -> "TargetProgress":
        return self

    @property
    def finished(self) -> bool:
        """Whether the last target has been reached."""
        return self.index >= self.count


class TargetSequence(LeafSystem):
    """Hands out target poses, each until the end effector has reached it.

    .. pydrake_system::

        name: TargetSequence
        input_ports:
        - configuration
        output_ports:
        - target
        - progress

    `configuration` takes the measured q, `target` gives the present pose X_WT
    as a `RigidTransform`, `progress` a `TargetProgress`. After the last
    target it keeps handing that one out. Arrival is judged once a period.

    Args:
        robot: The robot, for its kinematics.
        X_WTs: Target poses of the end effector, at least one.
        arrival: The success rule; None: within 20 mm and 2 degrees.
        period: Time between two judgements of arrival [s].

    Example:
        >>> import remosplat_drake as rs
        >>> from pydrake.math import RigidTransform
        >>> robot = rs.load_robot("frankie")
        >>> X_WT = RigidTransform([0.9, 0.3, 1.0])
        >>> targets = rs.TargetSequence(robot=robot, X_WTs=[X_WT])
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        X_WTs: Sequence[RigidTransform],
        arrival: ArrivalConfig | None = None,
        period: float = 0.01,
    ):
        super().__init__()
        self.set_name("targets")
        self._robot = robot
        self._X_WTs = list(X_WTs)
        self._arrival = arrival or ArrivalConfig()
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._progress_index = self.DeclareAbstractState(
            Value(TargetProgress(0, len(self._X_WTs)))
        )
        self.DeclareAbstractOutputPort(
            "target",
            Value(RigidTransform()).Clone,
            self._calc_target,
            {self.abstract_state_ticket(self._progress_index)},
        )
        self.DeclareStateOutputPort("progress", self._progress_index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._judge)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, configuration: OutputPort, **arguments
    ) -> "TargetSequence":
        """Adds a sequence to a diagram, and connects its input.

        Args:
            builder: Builder of the diagram.
            configuration: The measured configuration q.
            **arguments: The arguments of `TargetSequence`.
        """
        targets = builder.AddSystem(TargetSequence(**arguments))
        builder.Connect(configuration, targets.GetInputPort("configuration"))
        return targets

    def progress(self, context: Context) -> TargetProgress:
        """Returns how far along the sequence the robot is.

        Args:
            context: The system's own context.
        """
        cell = int(self._progress_index)
        return context.get_abstract_state(cell).get_value()

    def error(self, context: Context) -> PoseError:
        """Returns the error from the end effector to the present target.

        Args:
            context: The system's own context.
        """
        X_WE = self._robot.end_effector_pose(
            self._configuration_input.Eval(context)
        )
        return pose_error(X_WE, self._target(context).GetAsMatrix4())

    def _target(self, context: Context) -> RigidTransform:
        index = self.progress(context).index
        return self._X_WTs[min(index, len(self._X_WTs) - 1)]

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(self._target(context))

    def _judge(self, context: Context, state: State):
        progress = self.progress(context)
        if progress.finished or not has_arrived(
            self.error(context), self._arrival
        ):
            return
        state.get_mutable_abstract_state(int(self._progress_index)).set_value(
            dc.replace(progress, index=progress.index + 1)
        )
