"""`TaskSystem`: leads a robot through a task, as a Drake system."""

from collections.abc import Mapping

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    State,
)

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.aim import Aim
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
from remosplat_drake.task.task import DONE, FAILED, Task, TaskState
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
        - task

    `advance_task` computes the progress once a period. `aim`, `target` and
    `progress` are like those of a `TargetSequence`, except that `progress`
    counts blocks instead of targets. `distance_field` is the map with the
    objects that are not carried and the contact rules of the present step,
    `payload` the carried object, and `objects` all objects at their poses.
    `hold` is true if the arm must stand still: map and payload change only
    then. `hand_command` is the width and force of each hand [m, N],
    `hand_state` the width, rate and force of each, `task` the `TaskState`, and
    `outline` the `TaskOutline` for display.

    Args:
        task: The task.
        map: The map of the task.
        widths: Opening of each hand at the start, by end effector [m].
        period: Control period [s].
    """

    def __init__(
        self,
        *,
        task: Task,
        map: TaskMap,
        widths: Mapping[int, float],
        period: float,
    ):
        super().__init__()
        self.set_name("targets")
        self._task, self._map, self._widths = task, map, widths
        robot = task.robot
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
        self._state_index = self.DeclareAbstractState(
            Value(TaskState(task.objects, since=-np.inf))
        )
        present = {self.abstract_state_ticket(self._state_index)}
        moving = present | {self._configuration_input.ticket()}
        for name, model, calc, tickets in (
            ("target", Value(RigidTransform()), self._calc_target, moving),
            ("aim", Value[object](), self._calc_aim, moving),
            (
                "progress",
                Value(TargetProgress(0, 0)),
                self._calc_progress,
                present,
            ),
            ("distance_field", Value[object](), self._calc_field, present),
            ("payload", Value(EMPTY), self._calc_payload, present),
            ("objects", Value[object](), self._calc_objects, present),
            ("hold", Value(False), self._calc_hold, present),
            ("outline", Value(TaskOutline()), self._calc_outline, present),
        ):
            self.DeclareAbstractOutputPort(name, model.Clone, calc, tickets)
        self.DeclareVectorOutputPort(
            "hand_command", 2 * len(widths), self._calc_hands, present
        )
        self.DeclareStateOutputPort("task", self._state_index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._judge)

    def state(self, context: Context) -> TaskState:
        """Returns the progress of the task in detail.

        Args:
            context: The system's own context.
        """
        return context.get_abstract_state(int(self._state_index)).get_value()

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress along the blocks of the task.

        Args:
            context: The system's own context.
        """
        state, count = self.state(context), len(self._task.blocks)
        if state.outcome == DONE:
            return TargetProgress(count, count)
        step = state.present(self._task)
        failed = state.failures[-1] if state.outcome == FAILED else ""
        return TargetProgress(state.block, count, step.text, failed)

    def error(self, context: Context) -> PoseError:
        """Returns the pose error to the goal of the present step.

        Args:
            context: The system's own context.
        """
        state = self.state(context)
        q = self._configuration_input.Eval(context)
        return error_to(self._task, state, state.present(self._task), q)

    def _aim(self, context: Context) -> Aim:
        q = self._configuration_input.Eval(context)
        return aim_of(self._task, self.state(context), q)

    def _calc_aim(self, context: Context, output: AbstractValue):
        output.set_value(self._aim(context))

    def _calc_target(self, context: Context, output: AbstractValue):
        output.set_value(RigidTransform(self._aim(context).first.X_WT))

    def _calc_progress(self, context: Context, output: AbstractValue):
        output.set_value(self.progress(context))

    def _calc_field(self, context: Context, output: AbstractValue):
        output.set_value(self._map.field(self.state(context)))

    def _calc_payload(self, context: Context, output: AbstractValue):
        output.set_value(Load(self.state(context).payload))

    def _calc_objects(self, context: Context, output: AbstractValue):
        output.set_value(self.state(context).objects)

    def _calc_hold(self, context: Context, output: AbstractValue):
        state = self.state(context)
        moves = state.begun and state.present(self._task).goal is not None
        output.set_value(not moves)

    def _calc_outline(self, context: Context, output: AbstractValue):
        output.set_value(outline(self._task, self.state(context)))

    def _calc_hands(self, context: Context, output: BasicVector):
        told = self.state(context).told
        start = {i: (width, FORCE) for i, width in self._widths.items()}
        commands = [told.get(i, start[i]) for i in start]
        output.SetFromVector(np.ravel(commands))

    def _judge(self, context: Context, state: State):
        before = self.state(context)
        hands = {}
        if self._hand_input.HasValue(context):
            readings = self._hand_input.Eval(context).reshape(-1, 3)
            hands = dict(
                zip(self._widths, map(HandReading.of, readings), strict=True)
            )
        now = Observation(
            context.get_time(),
            np.array(self._configuration_input.Eval(context)),
            np.array(self._velocity_input.Eval(context)),
            np.array(self._executed_input.Eval(context)),
            hands,
        )
        after = advance_task(self._task, before, now)
        if after is not before:
            cell = int(self._state_index)
            state.get_mutable_abstract_state(cell).set_value(after)
