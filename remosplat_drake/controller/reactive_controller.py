"""`ReactiveController`: a Drake system that evaluates the control law."""

import dataclasses as dc
from time import perf_counter

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.program.guidance import DIRECT
from remosplat_drake.controller.rest import (
    Rest,
    RestRule,
    advance_rest,
    at_rest,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.robot.braking import periods_between
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.load import EMPTY, payload_of
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.target_ports import (
    TargetPorts,
    connect_target,
)
from remosplat_drake.signals.tick_report import TickReport


class ReactiveController(LeafSystem):
    """Solves a quadratic program at each tick, and holds its command.

    .. pydrake_system::

        name: ReactiveController
        input_ports:
        - configuration
        - clearances
        - distance_field
        - target (optional)
        - aim (optional)
        - selection (optional)
        - velocity_executed (optional)
        - motion (optional)
        - movers (optional)
        - payload (optional)
        - hold (optional)
        output_ports:
        - velocity_commanded
        - report

    The command is discrete state, which is updated once per control period. So
    the number of solved programs does not depend on the integration steps of
    the station, and there is no algebraic loop between station and controller.

    Connect one of the two inputs for the target: `target` is the pose X_WT as a
    `RigidTransform`, and `aim` is an `Aim` or a `Target`. The input `selection`
    is the output of a `GuidanceSelector`; if it is not connected, the
    controller always moves directly to the target. `velocity_executed` is the
    command that the supervisor passed on; if it is not connected, the
    controller assumes that its own command is executed. `motion` is the
    `Motion` of a robot with delay; `configuration` and `clearances` must then
    be those of its `q_planned`. `movers` are the `Movers` around the robot; if
    the port is not connected, there are none. `payload` is the robot's `Load`,
    with which `clearances` were computed; it may change only at standstill.
    While `hold` is true, each command is the next step of the braking ramp, so
    the robot stops and remains at rest.

    The output `report` is the `TickReport` of the latest tick. Viewers and
    loggers read it, so they do not query the oracle again.

    Args:
        law: The control law; its `dt` is the period of the updates [s].
        rest: Conditions of rest at a reached target; None if the robot never
            rests.

    Example:
        >>> import remosplat_drake as rs
        >>> from pydrake.systems.framework import DiagramBuilder
        >>> from pydrake.systems.primitives import ConstantVectorSource
        >>> builder = DiagramBuilder()
        >>> robot = rs.load_robot("frankie")
        >>> q = builder.AddSystem(ConstantVectorSource(robot.q_home))
        >>> scene = rs.read_scene("package://remosplat_drake/models/scenes/table/scene.json")
        >>> oracle = rs.DistanceOracle.AddToBuilder(
        ...     builder,
        ...     robot=robot,
        ...     field=rs.GroundTruth().make(truth=scene),
        ...     configuration=q.get_output_port(),
        ... )
        >>> law = rs.ReactiveLaw(robot, rs.default_ingredients(robot))
        >>> controller = rs.ReactiveController.AddToBuilder(
        ...     builder,
        ...     law=law,
        ...     oracle=oracle,
        ...     configuration=q.get_output_port(),
        ... )
    """

    def __init__(self, *, law: ReactiveLaw, rest: RestRule | None = None):
        super().__init__()
        self.set_name("controller")
        self._law, self._rest = law, rest
        n_q, n_u = law.robot.n_q, law.robot.n_u
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", n_q
        )
        self._clearances_input = self.DeclareAbstractInputPort(
            "clearances", Value(Clearances.none())
        )
        self._field_input = self.DeclareAbstractInputPort(
            "distance_field", Value[object]()
        )
        self._target = TargetPorts.declare(self)
        self._selection_input = self.DeclareAbstractInputPort(
            "selection", Value(Selection(DIRECT))
        )
        self._executed_input = self.DeclareVectorInputPort(
            "velocity_executed", n_u
        )
        self._motion_input = self.DeclareAbstractInputPort(
            "motion", Value[object]()
        )
        self._movers_input = self.DeclareAbstractInputPort(
            "movers", Value[object]()
        )
        self._payload_input = self.DeclareAbstractInputPort(
            "payload", Value(EMPTY)
        )
        self._hold_input = self.DeclareAbstractInputPort("hold", Value(False))
        self._report_index = self.DeclareAbstractState(
            Value(TickReport.before_first(n_q, n_u))
        )
        self._rest_index = self.DeclareAbstractState(Value(Rest()))
        self.DeclareVectorOutputPort(
            "velocity_commanded",
            n_u,
            self._calc_command,
            {self.abstract_state_ticket(self._report_index)},
        )
        self.DeclareStateOutputPort("report", self._report_index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(law.dt, 0.0, self._tick)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        law: ReactiveLaw,
        oracle: LeafSystem,
        configuration: OutputPort | None = None,
        target: OutputPort | None = None,
        rest: RestRule | None = None,
    ) -> "ReactiveController":
        """Adds a controller, and connects it to a `DistanceOracle`.

        Args:
            builder: The builder of the diagram.
            law: The control law.
            oracle: The system that computes distances, with the output ports
                `clearances` and `distance_field`.
            configuration: The output port of the measured q, n_q entries; None
                leaves the input unconnected.
            target: The output port of the target, whose value is an `Aim`, a
                `Target`, or the pose X_WT as a `RigidTransform`; None leaves
                the inputs unconnected.
            rest: Conditions of rest at a reached target; None if the robot
                never rests.

        Returns:
            The controller, which is now part of the diagram.
        """
        controller = builder.AddSystem(ReactiveController(law=law, rest=rest))
        for name in ("clearances", "distance_field"):
            builder.Connect(
                oracle.GetOutputPort(name), controller.GetInputPort(name)
            )
        if configuration is not None:
            builder.Connect(
                configuration, controller.GetInputPort("configuration")
            )
        if target is not None:
            connect_target(builder, target, controller)
        return controller

    def _calc_command(self, context: Context, output: BasicVector):
        report = context.get_abstract_state(int(self._report_index)).get_value()
        output.SetFromVector(report.command)

    def _tick(self, context: Context, state: State):
        cell = int(self._report_index)
        selection, executed = self._selection(context), self._executed(context)
        start = perf_counter()
        clearances = self._clearances_input.Eval(context)
        after_oracle = perf_counter()
        law = self._law.holding(payload_of(self._payload_input, context))
        report = run_tick(
            law,
            context.get_time(),
            self._configuration_input.Eval(context),
            self._target.read(context),
            clearances,
            self._field_input.Eval(context),
            executed,
            selection.guidance,
            motion=value_or_none(self._motion_input, context),
            movers=value_or_none(self._movers_input, context),
            periods=self._periods(context),
        )
        report = self._rested(context, state, report, executed)
        if value_or_none(self._hold_input, context):
            report = at_rest(law, report, executed, self._periods(context))
        timings = {
            "guidance": selection.seconds,
            "oracle": after_oracle - start,
            **report.timings,
            "total": selection.seconds + perf_counter() - start,
        }
        state.get_mutable_abstract_state(cell).set_value(
            dc.replace(report, timings=timings)
        )

    def _rested(
        self,
        context: Context,
        state: State,
        report: TickReport,
        executed: np.ndarray,
    ) -> TickReport:
        """Replaces the command by a braking ramp if the robot should rest."""
        if self._rest is None:
            return report
        cell = int(self._rest_index)
        before = context.get_abstract_state(cell).get_value()
        law = self._law.holding(report.payload)
        rest = advance_rest(self._rest, law, before, report)
        state.get_mutable_abstract_state(cell).set_value(rest)
        if not rest.is_still:
            return report
        return at_rest(law, report, executed, self._periods(context))

    def _periods(self, context: Context) -> float:
        """Returns the number of periods since the previous tick."""
        cell = int(self._report_index)
        before = context.get_abstract_state(cell).get_value().time
        return periods_between(before, context.get_time(), self._law.dt)

    def _executed(self, context: Context) -> np.ndarray:
        """Returns the previous tick's command, as it was sent to the robot."""
        if self._executed_input.HasValue(context):
            return np.array(self._executed_input.Eval(context))
        cell = int(self._report_index)
        return context.get_abstract_state(cell).get_value().command

    def _selection(self, context: Context) -> Selection:
        if self._selection_input.HasValue(context):
            return self._selection_input.Eval(context)
        return Selection(DIRECT)
