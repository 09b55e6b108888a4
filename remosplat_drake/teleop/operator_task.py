"""`OperatorTask`: an operator's jobs with objects, as a Drake system."""

from collections.abc import Mapping

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DependencyTicket,
    DiagramBuilder,
    OutputPort,
)

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.task.advance_task import Observation
from remosplat_drake.task.job_search import JobSearch
from remosplat_drake.task.target_sequence import TargetProgress
from remosplat_drake.task.task import Task, Work
from remosplat_drake.task.task_map import MapAround, TaskMap
from remosplat_drake.task.task_system import TaskSystem
from remosplat_drake.teleop.operator_jobs import Jobs, advance_jobs
from remosplat_drake.teleop.operator_target import OperatorTarget


class OperatorTask(TaskSystem):
    """Outputs the targets of an operator's jobs, or else the operator's target.

    .. pydrake_system::

        name: OperatorTask
        input_ports:
        - configuration
        - velocity_measured
        - velocity_executed
        - hand_state (optional)
        - command
        - operator_aim
        - operator_hand (optional)
        - supervision (optional)
        - scene (optional)
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
        - job
        - surroundings
        - scene_map

    `command` takes the `OperatorCommand`, `operator_aim` the `Aim` and
    `operator_hand` the hand command of an `OperatorTarget`, and `supervision`
    the `SupervisorState`. While there is no job, `aim` and `hand_command` equal
    the operator's inputs, except that a hand keeps an object that it carries.
    `job` outputs the description of the job's state, which is empty without a
    job. All other ports are those of a `TaskSystem`. `advance_jobs` computes
    the progress.

    `scene` takes the `DistanceField` of a live map, which does not contain the
    objects. It replaces the distance field of `map`. `surroundings` outputs a
    `TaskSurroundings`. Without a live map, `scene_map` outputs the `SceneMap`
    without the objects. It changes when an operator finds an object in it.

    The outputs depend on `supervision` and `command` only through the periodic
    update, which also calls `search`. While `search` returns None, the robot is
    held.

    Args:
        search: Function that searches for the steps of a job.
        task: The robot and the objects, without blocks.
        map: The map of the task.
        scene: The map without the objects; None with a live map.
        widths: Opening of each hand at the start, keyed by end effector [m].
        period: Control period [s].
    """

    def __init__(
        self,
        *,
        search: JobSearch,
        task: Task,
        map: TaskMap,
        scene: SceneMap | None,
        widths: Mapping[int, float],
        period: float,
    ):
        super().__init__(
            work=Jobs.none(task, scene), map=map, widths=widths, period=period
        )
        self.set_name("jobs")
        self._search = search
        self.DeclareAbstractOutputPort(
            "job",
            Value("").Clone,
            self._calc_job,
            {self.abstract_state_ticket(self._work_index)},
        )
        self.DeclareAbstractOutputPort(
            "surroundings",
            Value[object]().Clone,
            self._calc_surroundings,
            {self.abstract_state_ticket(self._work_index)},
        )
        if scene is not None:
            self.DeclareAbstractOutputPort(
                "scene_map",
                Value[object]().Clone,
                self._calc_scene_map,
                {self.abstract_state_ticket(self._work_index)},
            )

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        configuration: OutputPort,
        command: OutputPort,
        operator: OperatorTarget,
        **arguments,
    ) -> "OperatorTask":
        """Adds the system to a diagram, behind an operator's target.

        Args:
            builder: Builder of the diagram.
            configuration: The measured configuration q.
            command: The `OperatorCommand`.
            operator: The target that the operator moves while there is no job.
            **arguments: The arguments of `OperatorTask`.
        """
        system = builder.AddSystem(OperatorTask(**arguments))
        pairs = [
            (configuration, "configuration"),
            (command, "command"),
            (operator.GetOutputPort("aim"), "operator_aim"),
        ]
        if operator.HasOutputPort("hand_command"):
            hand = operator.GetOutputPort("hand_command")
            pairs.append((hand, "operator_hand"))
        for port, name in pairs:
            builder.Connect(port, system.GetInputPort(name))
        builder.Connect(
            system.GetOutputPort("job"), operator.GetInputPort("job")
        )
        return system

    def _declare_inputs(
        self,
        aim: set[DependencyTicket],
        hands: set[DependencyTicket],
        field: set[DependencyTicket],
    ) -> None:
        self._command_input = self.DeclareAbstractInputPort(
            "command", Value(OperatorCommand())
        )
        self._aim_input = self.DeclareAbstractInputPort(
            "operator_aim", Value[object]()
        )
        self._operator_hand_input = self.DeclareVectorInputPort(
            "operator_hand", 2
        )
        self._supervision_input = self.DeclareAbstractInputPort(
            "supervision", Value(SupervisorState(np.zeros(self._robot.n_u)))
        )
        self._scene_input = self.DeclareAbstractInputPort(
            "scene", Value[object]()
        )
        aim.add(self._aim_input.ticket())
        field.add(self._scene_input.ticket())
        hands.add(self._operator_hand_input.ticket())

    def _jobs(self, context: Context) -> Jobs:
        jobs = self._work(context)
        assert isinstance(jobs, Jobs)
        return jobs

    def progress(self, context: Context) -> TargetProgress:
        """Returns the progress of a sequence that never ends: 0 of 1.

        Args:
            context: The system's own context.
        """
        jobs = self._jobs(context)
        doing = jobs.state.present(jobs.task).text if jobs.runs else ""
        return TargetProgress(0, 1, doing)

    def error(self, context: Context) -> PoseError:
        """Returns the pose error to the goal of a job, or to the target.

        Args:
            context: The system's own context.
        """
        if self._jobs(context).runs:
            return super().error(context)
        q = self._configuration_input.Eval(context)
        effector, target = self._aim(context).items[0]
        return target.error(self._robot.end_effector_poses(q)[effector])

    def _aim(self, context: Context) -> Aim:
        jobs = self._jobs(context)
        if jobs.runs and jobs.state.X_WT is not None:
            return super()._aim(context)
        return self._aim_input.Eval(context)

    def _holds(self, context: Context) -> bool:
        jobs = self._jobs(context)
        return super()._holds(context) if jobs.runs else jobs.leads

    def _hands(self, context: Context) -> dict[int, tuple[float, float]]:
        jobs = self._jobs(context)
        commands = super()._hands(context)
        if jobs.leads or not self._operator_hand_input.HasValue(context):
            return commands
        (only,) = commands
        if not jobs.state.held:
            width, force = self._operator_hand_input.Eval(context)
            commands[only] = (width, force)
        return commands

    def _scene(self, context: Context) -> DistanceField:
        own = self._jobs(context).scene
        initial = self._map.scene if own is None else own.field
        return value_or_none(self._scene_input, context) or initial

    def _calc_surroundings(self, context: Context, output: AbstractValue):
        state = self._jobs(context).state
        output.set_value(MapAround(self._map, self._robot, state))

    def _calc_scene_map(self, context: Context, output: AbstractValue):
        output.set_value(self._jobs(context).scene)

    def _calc_job(self, context: Context, output: AbstractValue):
        output.set_value(self._jobs(context).text)

    def _advanced(self, context: Context, work: Work, now: Observation) -> Work:
        assert isinstance(work, Jobs)
        self._map.scene = scene = self._scene(context)
        supervision = value_or_none(self._supervision_input, context)
        return advance_jobs(
            self._search,
            work,
            self._command_input.Eval(context),
            now,
            scene,
            is_stopped=supervision is not None and supervision.is_latched,
        )
