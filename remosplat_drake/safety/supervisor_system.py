"""`SafetySupervisor`: passes commands to the station, or stops the robot."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
    State,
    ValueProducer,
)

from remosplat_drake.safety.supervision import Observation, SupervisorLaw
from remosplat_drake.safety.supervisor import supervise
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import (
    STOPPED,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.tick_report import TickReport

STOP_BUTTON = "stop button"
"""Reason of a stop that the page's stop button causes."""


@dc.dataclass(frozen=True, eq=False)
class _Sample:
    """The inputs of a tick, sampled before the controller's computation."""

    time: float
    status: StationStatus
    u_measured: np.ndarray
    motion: Motion | None
    map_age: float
    movers: Movers | None
    operator: OperatorRequests
    stop: str
    release: bool


@dc.dataclass(frozen=True, eq=False)
class _Memory:
    """The system's state between two ticks; copying returns the object itself.

    Attributes:
        before: The supervisor's state after the previous tick.
        sample: The inputs of the present tick; None before the first one.
        stop: Reason of a stop that a program requests for the next tick.
        release: Whether a program releases the stop at the next tick.
    """

    before: SupervisorState
    sample: _Sample | None = None
    stop: str = ""
    release: bool = False

    def __deepcopy__(self, memo) -> "_Memory":
        return self


class SafetySupervisor(LeafSystem):
    """Passes on the controller's commands, and stops the robot after a fault.

    .. pydrake_system::

        name: SafetySupervisor
        input_ports:
        - velocity_commanded
        - report
        - status
        - velocity_measured
        - motion (optional)
        - map_age (optional)
        - map_hold (optional)
        - movers (optional)
        - operator (optional)
        output_ports:
        - velocity_commanded
        - supervision

    Measurements are sampled once per control period, at the time of the
    controller's tick. The command passes through without delay, so it acts from
    the tick at which the controller computed it. There is no algebraic loop,
    because the output depends only on the sample and on the controller's state.
    The output changes only at ticks.

    Both the input and the output `velocity_commanded` are the command u, shape
    (n_u,) [m/s, rad/s]. The input `report` is the controller's `TickReport`,
    `status` the `StationStatus`, and `velocity_measured` the measured u.
    `motion` is the predicted `Motion` of a robot with delay, and `map_age` the
    age of the map [s]. `map_hold` is the reason why a new map is not used
    before the robot stops; it is empty if there is no such map. `operator`
    contains the `OperatorRequests` of a stop button. If the button reports a
    problem, the robot is stopped, too. `movers` are the `Movers`, which must
    not be stale. The output `supervision` is the `SupervisorState`. A stop is
    latched until it is released.

    Args:
        law: The thresholds and limits; its `dt` is the control period [s].
        armed: Whether the robot may start without a release. If not, it is
            stopped at the beginning, until a person arms it.

    Attributes:
        law: The thresholds and limits.

    Example:
        >>> import remosplat_drake as rs
        >>> application = rs.build(rs.load_scenario("TableReach"))
        >>> stops = application.supervisor.GetOutputPort("supervision")
    """

    def __init__(self, *, law: SupervisorLaw, armed: bool = True):
        super().__init__()
        self.set_name("supervisor")
        self.law = law
        n_u = len(law.velocity)
        self._command_input = self.DeclareVectorInputPort(
            "velocity_commanded", n_u
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(0, n_u))
        )
        self._status_input = self.DeclareAbstractInputPort(
            "status", Value(StationStatus())
        )
        self._measured_input = self.DeclareVectorInputPort(
            "velocity_measured", n_u
        )
        self._motion_input = self.DeclareAbstractInputPort(
            "motion", Value[object]()
        )
        self._map_age_input = self.DeclareVectorInputPort("map_age", 1)
        self._map_hold_input = self.DeclareAbstractInputPort(
            "map_hold", Value("")
        )
        self._movers_input = self.DeclareAbstractInputPort(
            "movers", Value[object]()
        )
        self._operator_input = self.DeclareAbstractInputPort(
            "operator", Value(OperatorRequests())
        )
        start = SupervisorState(np.zeros(n_u))
        if not armed:
            start = dc.replace(start, mode=STOPPED, reason=UNARMED)
        self._memory_index = self.DeclareAbstractState(Value(_Memory(start)))
        self._supervision = self.DeclareCacheEntry(
            "supervision",
            ValueProducer(allocate=Value(start).Clone, calc=self._calc),
            {
                self.abstract_state_ticket(self._memory_index),
                self._command_input.ticket(),
                self._report_input.ticket(),
            },
        )
        self.DeclareVectorOutputPort(
            "velocity_commanded",
            n_u,
            self._calc_command,
            {self._supervision.ticket()},
        )
        self.DeclareAbstractOutputPort(
            "supervision",
            Value(start).Clone,
            self._calc_supervision,
            {self._supervision.ticket()},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(law.dt, 0.0, self._tick)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        law: SupervisorLaw,
        controller: LeafSystem,
        armed: bool = True,
    ) -> "SafetySupervisor":
        """Adds a supervisor to a diagram, and connects it to a controller.

        Args:
            builder: Builder of the diagram.
            law: The thresholds and limits.
            controller: A `ReactiveController`, to which the executed command is
                fed back.
            armed: Whether the robot may start without a release.
        """
        supervisor = builder.AddSystem(SafetySupervisor(law=law, armed=armed))
        for name in ("velocity_commanded", "report"):
            builder.Connect(
                controller.GetOutputPort(name), supervisor.GetInputPort(name)
            )
        builder.Connect(
            supervisor.GetOutputPort("velocity_commanded"),
            controller.GetInputPort("velocity_executed"),
        )
        return supervisor

    def supervision(self, context: Context) -> SupervisorState:
        """Returns the present state of the supervisor.

        Args:
            context: The system's own context.
        """
        return self._supervision.Eval(context)

    def request_stop(self, context: Context, reason: str) -> None:
        """Stops the robot by the braking ramp, from the next tick on.

        Args:
            context: The system's own context, between two steps of a
                simulation.
            reason: Reason of the stop, as a text for a person.
        """
        self._change(context, stop=reason)

    def request_release(self, context: Context) -> None:
        """Releases a latched stop at the next tick, if no symptom exists then.

        Args:
            context: The system's own context, between two steps of a
                simulation.
        """
        self._change(context, release=True)

    def _change(self, context: Context, **changes) -> None:
        cell = int(self._memory_index)
        value = context.get_mutable_abstract_state(cell)
        value.set_value(dc.replace(value.get_value(), **changes))

    def _tick(self, context: Context, state: State):
        sample = self._sample(context)
        memory = _Memory(self._supervision.Eval(context), sample)
        cell = int(self._memory_index)
        state.get_mutable_abstract_state(cell).set_value(memory)

    def _sample(self, context: Context) -> _Sample:
        memory = self._memory(context)
        known = memory.sample.operator if memory.sample else OperatorRequests()
        operator = known
        if self._operator_input.HasValue(context):
            operator = self._operator_input.Eval(context)
        map_age = 0.0
        if self._map_age_input.HasValue(context):
            map_age = float(self._map_age_input.Eval(context)[0])
        hold = ""
        if self._map_hold_input.HasValue(context):
            hold = self._map_hold_input.Eval(context)
        pressed = STOP_BUTTON if operator.stops > known.stops else ""
        return _Sample(
            time=context.get_time(),
            status=self._status_input.Eval(context),
            u_measured=np.array(self._measured_input.Eval(context)),
            motion=value_or_none(self._motion_input, context),
            map_age=map_age,
            movers=value_or_none(self._movers_input, context),
            operator=operator,
            stop=memory.stop or operator.trouble or pressed or hold,
            release=memory.release or operator.releases > known.releases,
        )

    def _memory(self, context: Context) -> _Memory:
        return context.get_abstract_state(int(self._memory_index)).get_value()

    def _calc(self, context: Context, value: Value):
        memory = self._memory(context)
        sample = memory.sample
        if sample is None:
            value.set_value(memory.before)
            return
        now = Observation(
            time=sample.time,
            command=np.array(self._command_input.Eval(context)),
            report=self._report_input.Eval(context),
            status=sample.status,
            u_measured=sample.u_measured,
            motion=sample.motion,
            map_age=sample.map_age,
            movers=sample.movers,
            stop=sample.stop,
            release=sample.release,
        )
        value.set_value(supervise(self.law, memory.before, now))

    def _calc_command(self, context: Context, output: BasicVector):
        output.SetFromVector(self.supervision(context).command)

    def _calc_supervision(self, context: Context, output: Value):
        output.set_value(self.supervision(context))
