"""`TargetSequence`: hands out targets, one after the other."""

import dataclasses as dc
from collections.abc import Sequence
from functools import partial

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.target import Target
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
    """Hands out targets, each until the end effector has reached it.

    .. pydrake_system::

        name: TargetSequence
        input_ports:
        - configuration
        output_ports:
        - target
        - aim
        - progress

    `configuration` takes the measured q, `aim` gives the present `Target`,
    `target` its pose X_WT alone as a `RigidTransform`, and `progress` a
    `TargetProgress`. After the last target it keeps handing that one out.
    Arrival is judged once a period. A line starts where the end effector is
    when its turn comes; a target that is passed is told how far it is from
    there to where the end effector stops.

    Args:
        robot: The robot, for its kinematics.
        X_WTs: What the end effector shall reach, at least one: poses, or
            `Target`s where less is asked, or more. A line's start is that
            of the motion, whatever the target says.
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
        X_WTs: Sequence[RigidTransform | Target],
        arrival: ArrivalConfig | None = None,
        period: float = 0.01,
    ):
        super().__init__()
        self.set_name("targets")
        self._robot = robot
        self._targets = with_ways_onward([Target.of(x) for x in X_WTs])
        self._arrival = partial(has_arrived, config=arrival or ArrivalConfig())
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._progress_index = self.DeclareAbstractState(
            Value(TargetProgress(0, len(self._targets)))
        )
        # Where the end effector was when the present target's turn came; not
        # finite: not known yet (an abstract value cannot hold None).
        self._start_index = self.DeclareAbstractState(
            Value[object](np.full((4, 4), np.nan))
        )
        tickets = {
            self.abstract_state_ticket(self._progress_index),
            self.abstract_state_ticket(self._start_index),
            self._configuration_input.ticket(),
        }
        self.DeclareAbstractOutputPort(
            "target",
            Value(RigidTransform()).Clone,
            self._calc_target,
            {self.abstract_state_ticket(self._progress_index)},
        )
        self.DeclareAbstractOutputPort(
            "aim", Value[object]().Clone, self._calc_aim, tickets
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
        return self._listed(context).error(self._end_effector(context))

    def _end_effector(self, context: Context) -> np.ndarray:
        q = self._configuration_input.Eval(context)
        return self._robot.end_effector_pose(q)

    def _listed(self, context: Context) -> Target:
        index = self.progress(context).index
        return self._targets[min(index, len(self._targets) - 1)]

    def _start(self, context: Context) -> np.ndarray:
        cell = int(self._start_index)
        start = context.get_abstract_state(cell).get_value()
        if np.isfinite(start).all():
            return start
        return self._end_effector(context)

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(RigidTransform(self._listed(context).X_WT))

    def _calc_aim(self, context: Context, output: AbstractValue):
        target = self._listed(context)
        if target.line is not None:
            line = dc.replace(target.line, X_WA=self._start(context))
            target = dc.replace(target, line=line)
        output.set_value(target)

    def _judge(self, context: Context, state: State):
        start = state.get_mutable_abstract_state(int(self._start_index))
        X_WE = self._end_effector(context)
        if not np.isfinite(start.get_value()).all():
            start.set_value(X_WE)
        progress, target = self.progress(context), self._listed(context)
        if progress.finished or not target.is_reached(
            target.error(X_WE), self._arrival
        ):
            return
        progress = dc.replace(progress, index=progress.index + 1)
        state.get_mutable_abstract_state(int(self._progress_index)).set_value(
            progress
        )
        if not progress.finished:
            start.set_value(X_WE)


def with_ways_onward(targets: Sequence[Target]) -> list[Target]:
    """Tells targets that are passed how far it is from there to a stop.

    Args:
        targets: The targets, in their order.
    """
    result: list[Target] = []
    for target in reversed(targets):
        onward = 0.0
        if target.passed_within is not None and result:
            way = result[-1].X_WT[:3, 3] - target.X_WT[:3, 3]
            onward = float(np.linalg.norm(way)) + result[-1].onward
        result.append(dc.replace(target, onward=onward))
    return result[::-1]
