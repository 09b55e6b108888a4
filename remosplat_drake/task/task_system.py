"""`TaskSystem`: a Drake system that executes the steps of a task."""

from collections.abc import Mapping

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    LeafSystem,
    State,
)

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.hand_reading import HandReading
from remosplat_drake.signals.load import EMPTY, Load
from remosplat_drake.signals.task_outline import TaskOutline
from remosplat_drake.task.advance_task import (
    Observation,
    advance_task,
    error_to,
)
from remosplat_drake.task.outline import outline
from remosplat_drake.task.step import FORCE
from remosplat_drake.task.step_aim import aim_of
from remosplat_drake.task.target_sequence import TargetProgress
from remosplat_drake.task.task import DONE, FAILED, TaskState, Work
from remosplat_drake.task.task_map import TaskMap


class TaskSystem(LeafSystem):
    """Outputs the targets, contact rules and hand commands of a task's steps.

    .. pydrake_system::

        name: TaskSystem
        input_ports:
        - configuration
        - velocity_measured
        - velocity_executed
        - hand_state (optional)
        output_ports:
        - target
        - aim
        - progress
        - distance_field
        - payload
        - hold
        - objects
        - hand_command
        - outline

    `advance_task` computes the progress once a period. `aim`, `target` and
    `progress` are like the ports of a `TargetSequence`, except that `progress`
    counts blocks instead of targets. `distance_field` outputs the map, with the
    objects that are not carried and the contact rules of the present step.
    `payload` outputs the carried object, and `objects` all objects at their
    poses. `hold` is true if the arm must stand still; map and payload change
    only then. `hand_command` outputs the width and force of each hand [m, N],
    and `hand_state` takes the width, rate and force of each hand. `outline`
    outputs the `TaskOutline` for display.

    A subclass may change the task during the run, by overriding `_advanced`.

    Args:
        work: The task, and its state at the start.
        map: The map of the task.
        widths: Opening of each hand at the start, by end effector [m].
        period: Control period [s].
    """

    def __init__(
        self,
        *,
        work: Work,
        map: TaskMap,
        widths: Mapping[int, float],
        period: float,
    ):
        super().__init__()
        self.set_name("targets")
        self._map, self._widths = map, widths
        self._robot = robot = work.task.robot
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._velocity_input = self.DeclareVectorInputPort(
            "velocity_measured", robot.n_u
        )
        self._executed_input = self.DeclareVectorInputPort(
            "velocity_executed", robot.n_u
        )
        self._hand_input = self.DeclareVectorInputPort(
            "hand_state", 3 * len(widths)
        )
        self._work_index = self.DeclareAbstractState(Value[object](work))
        present = {self.abstract_state_ticket(self._work_index)}
        moving = present | {self._configuration_input.ticket()}
        hands, field = set(present), set(present)
        self._declare_inputs(moving, hands, field)
        for name, model, calc, tickets in (
            ("target", Value(RigidTransform()), self._calc_target, moving),
            ("aim", Value[object](), self._calc_aim, moving),
            (
                "progress",
                Value(TargetProgress(0, 0)),
                self._calc_progress,
                present,
            ),
            ("distance_field", Value[object](), self._calc_field, field),
            ("payload", Value(EMPTY), self._calc_payload, present),
            ("objects", Value[object](), self._calc_objects, present),
            ("hold", Value(False), self._calc_hold, present),
            ("outline", Value(TaskOutline()), self._calc_outline, present),
        ):
            self.DeclareAbstractOutputPort(name, model.Clone, calc, tickets)
        self.DeclareVectorOutputPort(
            "hand_command", 2 * len(widths), self._calc_hands, hands
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._judge)

    def _declare_inputs(
        self,
        aim: set[DependencyTicket],
        hands: set[DependencyTicket],
        field: set[DependencyTicket],
    ) -> None:
        """Declares further inputs of a subclass.

        Args:
            aim: Tickets on which the aim depends; others may be added.
            hands: Tickets on which the hand command depends.
            field: Tickets on which the map depends.
        """

    def _scene(self, context: Context) -> DistanceField:
        """The map without the objects."""
        return self._map.scene

    def state(self, context: Context) -> TaskState:
        """Returns the progress of the task in detail.

        Args:
            context: The system's own context.
        """
        return self._work(context).state

    def _work(self, context: Context) -> Work:
        return context.get_abstract_state(int(self._work_index)).get_value()

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress along the blocks of the task.

        Args:
            context: The system's own context.
        """
        work = self._work(context)
        state, count = work.state, len(work.task.blocks)
        if state.outcome == DONE:
            return TargetProgress(count, count)
        step = state.present(work.task)
        failed = state.failures[-1] if state.outcome == FAILED else ""
        return TargetProgress(state.block, count, step.text, failed)

    def error(self, context: Context) -> PoseError:
        """Returns the pose error to the goal of the present step.

        Args:
            context: The system's own context.
        """
        task, state = self._work(context).task, self.state(context)
        q = self._configuration_input.Eval(context)
        return error_to(task, state, state.present(task), q)

    def _aim(self, context: Context) -> Aim:
        q, work = self._configuration_input.Eval(context), self._work(context)
        return aim_of(work.task, work.state, q)

    def _calc_aim(self, context: Context, output: AbstractValue):
        output.set_value(self._aim(context))

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(RigidTransform(self._aim(context).first.X_WT))

    def _calc_progress(self, context: Context, output: AbstractValue):
        output.set_value(self.progress(context))

    def _calc_field(self, context: Context, output: AbstractValue):
        state, scene = self.state(context), self._scene(context)
        output.set_value(self._map.field(state, scene))

    def _calc_payload(self, context: Context, output: AbstractValue):
        output.set_value(Load(self.state(context).payload))

    def _calc_objects(self, context: Context, output: AbstractValue):
        output.set_value(self.state(context).objects)

    def _calc_hold(self, context: Context, output: AbstractValue):
        output.set_value(self._holds(context))

    def _holds(self, context: Context) -> bool:
        """Whether the arm must stand still."""
        work = self._work(context)
        moves = work.state.present(work.task).goal is not None
        return not (work.state.begun and moves)

    def _calc_outline(self, context: Context, output: AbstractValue):
        work = self._work(context)
        output.set_value(outline(work.task, work.state))

    def _calc_hands(self, context: Context, output: BasicVector):
        commands = self._hands(context).values()
        output.SetFromVector(np.ravel(list(commands)))

    def _hands(self, context: Context) -> dict[int, tuple[float, float]]:
        """The commanded opening and force of each hand [m, N]."""
        told = self.state(context).told
        return {
            i: told.get(i, (width, FORCE)) for i, width in self._widths.items()
        }

    def _judge(self, context: Context, state: State):
        before = self._work(context)
        after = self._advanced(context, before, self._observed(context))
        if after is not before:
            cell = int(self._work_index)
            state.get_mutable_abstract_state(cell).set_value(after)

    def _observed(self, context: Context) -> Observation:
        """The measurements of the robot."""
        hands = {}
        if self._hand_input.HasValue(context):
            readings = self._hand_input.Eval(context).reshape(-1, 3)
            hands = dict(
                zip(self._widths, map(HandReading.of, readings), strict=True)
            )
        return Observation(
            context.get_time(),
            np.array(self._configuration_input.Eval(context)),
            np.array(self._velocity_input.Eval(context)),
            np.array(self._executed_input.Eval(context)),
            hands,
        )

    def _advanced(self, context: Context, work: Work, now: Observation) -> Work:
        """The task and its state after a tick; `work` if nothing has changed.

        Args:
            context: The system's own context.
            work: The task and its state before the tick.
            now: The measurements of the robot.
        """
        state = advance_task(work.task, work.state, now)
        return work if state is work.state else Work(work.task, state)
