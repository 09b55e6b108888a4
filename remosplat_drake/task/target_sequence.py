"""`TargetSequence`: outputs targets, one after the other."""

import dataclasses as dc
from collections.abc import Mapping, Sequence
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

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.target import Target
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived

Wanted = Target | RigidTransform
"""Accepted types of a target."""


@dc.dataclass(frozen=True)
class TargetProgress:
    """Progress along a sequence of targets; a deep copy is the object itself.

    Attributes:
        index: Index of the present target; `count` after the last target.
        count: Number of targets in the sequence.
        doing: Description of the robot's present action; empty if the robot
            moves to the target.
        failed: Reason why the task has failed; empty if it has not failed.
        replaced: Number of targets that an operator has replaced.
    """

    index: int
    count: int
    doing: str = ""
    failed: str = ""
    replaced: int = 0

    def __deepcopy__(self, memo) -> "TargetProgress":
        return self

    @property
    def finished(self) -> bool:
        """Whether the last target has been reached."""
        return self.index >= self.count


@dc.dataclass(frozen=True, eq=False)
class _Place:
    """Progress of the end effectors; a deep copy is the object itself.

    Attributes:
        index: For each end effector, the index of its present target, or the
            number of its targets when it has reached all of them.
        aim: The present targets, without the starts of their lines.
        X_WA: For each end effector, its pose when its present target became
            current, shape (4, 4); None before the first update.
        replaced: New targets that replace targets of the sequence, keyed by
            index in the sequence of the first end effector.
        n_asked: Number of replacements so far.
    """

    index: tuple[int, ...]
    aim: Aim
    X_WA: tuple[np.ndarray, ...] | None = None
    replaced: Mapping[int, Target] = dc.field(default_factory=dict)
    n_asked: int = 0

    def __deepcopy__(self, memo) -> "_Place":
        return self


class TargetSequence(LeafSystem):
    """Outputs targets, each until the end effector has reached it.

    .. pydrake_system::

        name: TargetSequence
        input_ports:
        - configuration
        - instead (optional)
        output_ports:
        - target
        - aim
        - progress

    `configuration` takes the measured q. `aim` outputs the present `Aim`, and
    `target` only the pose X_WT of its first target, as a `RigidTransform`.
    `progress` outputs a `TargetProgress`, which counts the targets of all end
    effectors. `instead` takes a tuple of `Target`s, which may grow: each
    appended target replaces the present target of the first end effector. After
    the last target has been reached, it remains the target. Arrival is checked
    once per period. A line starts at the pose of the end effector when its
    target becomes current. The `onward` of a passed target is the length of the
    path from it to the next stop. Several end effectors do not wait for each
    other; the sequence is finished when all are at their last targets at the
    same time.

    Args:
        robot: The robot, for its kinematics.
        X_WTs: At least one target for the end effector: poses, or `Target`s for
            more options; or such lists by the names of several end effectors.
            The start `X_WA` of a target's line is ignored.
        arrival: The success rule. If None, an end effector has arrived within
            20 mm and 2 degrees.
        period: Time between two checks of arrival [s].

    Raises:
        RemoSplatError: There is no target, or no such end effector.

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
        X_WTs: Sequence[Wanted] | Mapping[str, Sequence[Wanted]],
        arrival: ArrivalConfig | None = None,
        period: float = 0.01,
    ):
        super().__init__()
        self.set_name("targets")
        self._robot = robot
        self._targets = _by_effector(robot, X_WTs)
        self._arrived = partial(has_arrived, config=arrival or ArrivalConfig())
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._instead_input = self.DeclareAbstractInputPort(
            "instead", Value[object](())
        )
        first = (0,) * len(self._targets)
        self._place_index = self.DeclareAbstractState(
            Value(_Place(first, self._present(first, {})))
        )
        place = self.abstract_state_ticket(self._place_index)
        self.DeclareAbstractOutputPort(
            "target",
            Value(RigidTransform()).Clone,
            self._calc_target,
            {place},
        )
        self.DeclareAbstractOutputPort(
            "aim",
            Value[object]().Clone,
            self._calc_aim,
            {place, self._configuration_input.ticket()},
        )
        self.DeclareAbstractOutputPort(
            "progress",
            Value(TargetProgress(0, 0)).Clone,
            self._calc_progress,
            {place},
        )
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
        """Returns the progress along the sequence.

        Args:
            context: The system's own context.
        """
        count, place = sum(map(len, self._targets)), self._place(context)
        return TargetProgress(
            sum(place.index), count, replaced=len(place.replaced)
        )

    def error(self, context: Context) -> PoseError:
        """Returns the largest error of an end effector to its present target.

        Args:
            context: The system's own context.
        """
        aim, X_WEs = self._place(context).aim, self._poses(context)
        effector, target = aim.farthest(X_WEs, self._arrived)
        return target.error(X_WEs[effector])

    def _poses(self, context: Context) -> np.ndarray:
        q = self._configuration_input.Eval(context)
        return self._robot.end_effector_poses(q)

    def _place(self, context: Context) -> _Place:
        return context.get_abstract_state(int(self._place_index)).get_value()

    def _present(
        self, index: tuple[int, ...], replaced: Mapping[int, Target]
    ) -> Aim:
        """Returns the present targets, without the starts of their lines."""
        present: list[Target | None] = [None] * len(self._targets)
        for i, listed in enumerate(self._targets):
            if listed:
                k = min(index[i], len(listed) - 1)
                target = replaced.get(k, listed[k]) if i == 0 else listed[k]
                # A target keeps arrays for kernels. Those of the copy are freed
                # with it, so that a long list needs no further memory.
                present[i] = dc.replace(target)
        return Aim(tuple(present))

    def _with_replaced(
        self, place: _Place, asked: tuple[Target, ...]
    ) -> _Place:
        """Replaces the present target of the first end effector."""
        replaced = {**place.replaced, place.index[0]: asked[-1]}
        aim = self._present(place.index, replaced)
        return dc.replace(place, aim=aim, replaced=replaced, n_asked=len(asked))

    def _calc_target(self, context: Context, output: AbstractValue):
        X_WT = self._place(context).aim.first.X_WT
        output.set_value(RigidTransform(X_WT))

    def _calc_aim(self, context: Context, output: AbstractValue):
        place = self._place(context)
        aim = place.aim
        if aim.has_line:
            X_WA = place.X_WA
            aim = begun(aim, X_WA or tuple(self._poses(context)))
        output.set_value(aim)

    def _calc_progress(self, context: Context, output: AbstractValue):
        output.set_value(self.progress(context))

    def _judge(self, context: Context, state: State):
        X_WE, before = self._poses(context), self._place(context)
        if self.progress(context).finished or not np.isfinite(X_WE).all():
            return
        cell = int(self._place_index)
        asked = value_or_none(self._instead_input, context) or ()
        if len(asked) > before.n_asked:
            place = self._with_replaced(before, asked)
            state.get_mutable_abstract_state(cell).set_value(place)
            return
        index, X_WA = list(before.index), list(before.X_WA or X_WE)
        for i, target in before.aim.items:
            last = len(self._targets[i]) - 1
            reached = target.is_reached(target.error(X_WE[i]), self._arrived)
            if index[i] < last and reached:
                index[i], X_WA[i] = index[i] + 1, X_WE[i]
            elif index[i] >= last:  # Held while other end effectors continue.
                index[i] = last + reached
        if before.X_WA is None or tuple(index) != before.index:
            place = dc.replace(
                before,
                index=tuple(index),
                aim=self._present(tuple(index), before.replaced),
                X_WA=tuple(X_WA),
            )
            state.get_mutable_abstract_state(cell).set_value(place)


def _by_effector(
    robot: RobotModel, wanted: Sequence[Wanted] | Mapping[str, Sequence[Wanted]]
) -> list[list[Target]]:
    """Returns the targets of each end effector."""
    names = robot.effectors
    if not isinstance(wanted, Mapping):
        wanted = {names[0]: wanted}
    for name in wanted:
        if name not in names:
            raise RemoSplatError(unknown_name("end effector", name, names))
    if not any(map(len, wanted.values())):
        raise RemoSplatError("a sequence needs at least one target")
    return [
        with_ways_onward([Target.of(x) for x in wanted.get(name, ())])
        for name in names
    ]


def begun(aim: Aim, X_WA: Sequence[np.ndarray]) -> Aim:
    """Sets the starts of all lines of an aim.

    Args:
        aim: The aim.
        X_WA: Start of the line of each end effector, shape (4, 4).
    """
    return Aim(
        tuple(
            target.on_line(X_WA[i], target.line.speed)
            if target and target.line
            else target
            for i, target in enumerate(aim.targets)
        )
    )


def with_ways_onward(targets: Sequence[Target]) -> list[Target]:
    """Sets `onward` of targets that are passed without a stop.

    `onward` is the length of the path from such a target to the next stop.

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
