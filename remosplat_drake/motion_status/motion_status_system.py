"""`MotionStatusSystem`: describes the robot's state in one sentence."""

import dataclasses as dc
from functools import partial

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.motion_status.hold import (
    Naming,
    beside_mover,
    find_hold,
    find_inside,
    present_hold,
)
from remosplat_drake.motion_status.names import name_thing
from remosplat_drake.motion_status.sentence import Situation, describe_motion
from remosplat_drake.motion_status.stillness import Stillness, observe
from remosplat_drake.motion_status.stop import find_stop
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.reach import beyond_reach
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion_status import NOT_STARTED, MotionStatus
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.thing import Thing
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived

UPDATE_PERIOD = 0.1
"""Time between two updates [s]."""


@dc.dataclass(frozen=True, eq=False)
class _Memory:
    """State between two updates; copying returns the object itself."""

    motion_status: MotionStatus = NOT_STARTED
    stillness: Stillness | None = None
    updated_at: float = -np.inf

    def __deepcopy__(self, memo) -> "_Memory":
        return self


class MotionStatusSystem(LeafSystem):
    """Describes the robot's state and its cause in one sentence.

    .. pydrake_system::

        name: MotionStatusSystem
        input_ports:
        - configuration
        - report
        - distance_field
        - progress (optional)
        - supervision (optional)
        - movers (optional)
        - selection (optional)
        output_ports:
        - motion_status

    The sentence is updated ten times per second. If the robot has not moved for
    the time `PAUSE`, the sentence states the cause until the robot moves again,
    so that it does not flicker; see `present_hold`. All times are by the
    diagram's clock.

    The input `configuration` is the measured q, `report` the controller's
    `TickReport`, `distance_field` the oracle's `DistanceField`, `progress` the
    `TargetProgress`, `supervision` the `SupervisorState`, `movers` the
    `Movers`, and `selection` the `Selection` of guidance. The output
    `motion_status` is the `MotionStatus`.

    Args:
        robot: The robot.
        arrival: Tolerances within which a target counts as reached.
        period: Control period [s].
        parked: Whether all speeds of the base are limited to zero.
        floor_height: Height in W below which a surface belongs to the floor
            [m].
        truth: The true scene, whose solids have names; None if unknown.
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        arrival: ArrivalConfig,
        period: float,
        parked: bool = False,
        floor_height: float = -np.inf,
        truth: SignedDistanceField | None = None,
    ):
        super().__init__()
        self.set_name("motion_status")
        self._robot = robot
        self._arrived = partial(has_arrived, config=arrival)
        self._parked = parked
        self._floor_height = floor_height
        self._truth = truth
        self._period = period
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(robot.n_q, robot.n_u))
        )
        self._field_input = self._declare("distance_field")
        self._progress_input = self._declare("progress")
        self._supervision_input = self._declare("supervision")
        self._movers_input = self._declare("movers")
        self._selection_input = self._declare("selection")
        self._memory_index = self.DeclareAbstractState(Value(_Memory()))
        self.DeclareAbstractOutputPort(
            "motion_status",
            Value(NOT_STARTED).Clone,
            self._calc_motion_status,
            {self.abstract_state_ticket(self._memory_index)},
        )
        # The event occurs at every tick, but updates the sentence only at some
        # of them. A separate, longer period would add event times between the
        # ticks.
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder, *, inputs: dict[str, OutputPort], **arguments
    ) -> "MotionStatusSystem":
        """Adds the system to a diagram, and connects its inputs.

        Args:
            builder: Builder of the diagram.
            inputs: Output ports to connect, keyed by the names of the input
                ports.
            **arguments: The arguments of `MotionStatusSystem`.
        """
        system = builder.AddSystem(MotionStatusSystem(**arguments))
        for name, port in inputs.items():
            builder.Connect(port, system.GetInputPort(name))
        return system

    def latest(self, context: Context) -> MotionStatus:
        """Returns the `MotionStatus` of the latest update.

        Args:
            context: The system's own context.
        """
        return self._memory(context).motion_status

    def now(self, context: Context) -> MotionStatus:
        """Computes the present `MotionStatus` without storing it.

        Args:
            context: The system's own context.
        """
        return self._updated(context).motion_status

    def _declare(self, name: str) -> InputPort:
        return self.DeclareAbstractInputPort(name, Value[object]())

    def _memory(self, context: Context) -> _Memory:
        return context.get_abstract_state(int(self._memory_index)).get_value()

    def _calc_motion_status(self, context: Context, output: Value):
        output.set_value(self.latest(context))

    def _update(self, context: Context, state: State):
        memory = self._memory(context)
        passed = context.get_time() - memory.updated_at
        # The tolerance of half a period is far greater than rounding errors.
        is_early = 0 <= passed < UPDATE_PERIOD - 0.5 * self._period
        if is_early and memory.motion_status is not NOT_STARTED:
            return
        cell = int(self._memory_index)
        updated = self._updated(context)
        state.get_mutable_abstract_state(cell).set_value(updated)

    def _updated(self, context: Context) -> _Memory:
        """Returns the memory after an update."""
        memory, time = self._memory(context), context.get_time()
        q = np.array(self._configuration_input.Eval(context))
        report = self._report_input.Eval(context)
        aim, X_WEs = report.aim, self._robot.end_effector_poses(q)
        effector, target = aim.farthest(X_WEs, self._arrived)
        error = target.error(X_WEs[effector])
        is_there = aim.is_reached(X_WEs, self._arrived)
        supervision = value_or_none(self._supervision_input, context)
        may_rest = is_there or not (supervision is None or supervision.runs)
        still = observe(
            memory.stillness, time, q, aim, X_WEs, may_rest=may_rest
        )
        name, before = self._naming(context), memory.motion_status.link
        robot = self._robot.holding(report.payload)
        selection = value_or_none(self._selection_input, context)
        hold = present_hold(
            still,
            time,
            partial(find_hold, report, robot, name, before),
            is_there=is_there,
            lacks=selection is not None and bool(selection.lack),
        )
        movers = value_or_none(self._movers_input, context)
        if hold is not None and movers is not None:
            hold = beside_mover(hold, robot, q, movers, time)
        stop = None
        if supervision is not None and supervision.is_latched:
            stop = find_stop(supervision, report, robot, name)
        situation = Situation(
            error=error,
            target=target,
            effector=self._robot.effectors[effector],
            beside_line=target.line_deviation(X_WEs[effector]),
            is_there=is_there,
            hold=hold,
            stop=stop,
            inside=find_inside(report, robot, name),
            beyond=self._beyond(aim, q),
            parked=self._parked and not self._beyond(aim, q, drives=True),
            no_nearer_for=time - still.nearest_at,
            progress=value_or_none(self._progress_input, context),
            supervision=supervision,
            selection=selection,
        )
        motion_status = describe_motion(situation, self._robot.description)
        return _Memory(motion_status, still, time)

    def _beyond(
        self, aim: Aim, q: np.ndarray, *, drives: bool = False
    ) -> float:
        """Returns a distance by which a target is at least out of reach [m]."""
        if not (aim.is_known and np.isfinite(q).all()):
            return 0.0
        parked = self._parked and not drives
        lacking = (
            beyond_reach(
                self._robot, q, target.X_WT[:3, 3], effector, parked=parked
            )
            for effector, target in aim.items
            if target.constrains_full_position
        )
        return max(lacking, default=0.0)

    def _naming(self, context: Context) -> Naming:
        field: DistanceField = self._field_input.Eval(context)

        def name(p_W: np.ndarray) -> Thing:
            return name_thing(field, p_W, self._floor_height, self._truth)

        return name
