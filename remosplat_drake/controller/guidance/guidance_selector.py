"""`GuidanceSelector`: selects guidance by rollouts, as a Drake system."""

import dataclasses as dc
from time import perf_counter

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    State,
)

from remosplat_drake.base.threads import num_threads
from remosplat_drake.controller.guidance.look_ahead_process import (
    LookAheadProcess,
)
from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.controller.guidance.selection import (
    Selection,
    on_the_same_world,
    start_selection,
)
from remosplat_drake.controller.guidance.selection_round import (
    advance_selection,
)
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.controller.guidance.stall_cycling import cycle_when_stalled
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.optional_input import value_or_none
from remosplat_drake.signals.target_ports import TargetPorts
from remosplat_drake.signals.tick_report import TickReport


class GuidanceSelector(LeafSystem):
    """Selects the guidance of the next ticks by rollouts.

    .. pydrake_system::

        name: GuidanceSelector
        input_ports:
        - configuration
        - target (optional)
        - aim (optional)
        - distance_field
        - report
        - movers (optional)
        - motion (optional)
        output_ports:
        - selection

    In each period, the selector simulates a fixed number of rollout steps, so
    results do not depend on the speed of the computer. Safety does not depend
    on the `Selection`, which may be late. Rollouts may use a coarser distance
    field than the controller; see `DistanceField.for_look_ahead`.

    Connect one of the two input ports for the target: `target` is the pose of
    the target, and `aim` is an `Aim` or a `Target`. For a target with a line no
    guidance is selected, since the line defines the path.

    If there is a `LookAheadProcess`, the selector only outputs the decisions of
    this process, and results depend on the speed of the computer. If the
    process is lost, the selector follows the candidates in turn, as with the
    budget 0, and `Selection.missing` contains the reason.

    The input `movers` are the `Movers` around the robot; if it is not
    connected, there are none. They move in rollouts, and are obstacles for
    paths. The input `motion` is the `Motion` of a robot with delay; rollouts
    include the delay, too.

    Args:
        rule: The selector's settings, such as the planner of candidates and the
            condition of arrival.
        budget: Number of rollout steps that are simulated in a period. With 0,
            the selector selects the next candidate whenever the robot stalls.
        period: Time between two updates [s].
        process: The process that computes the rollouts. If it is None, the
            selector computes them.

    Example:
        >>> import remosplat_drake as rs
        >>> scenario = rs.load_scenario("TableReach")
        >>> application = rs.build(scenario)
        >>> selection = application.selector.GetOutputPort("selection")
    """

    def __init__(
        self,
        *,
        rule: SelectionRule,
        budget: int,
        period: float,
        process: LookAheadProcess | None = None,
    ):
        super().__init__()
        self.set_name("guidance")
        self._rule = rule
        self._budget = budget
        self._threads = num_threads()
        self._process = process
        robot = rule.law.robot
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._target = TargetPorts.declare(self)
        self._field_input = self.DeclareAbstractInputPort(
            "distance_field", Value[object]()
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(robot.n_q, robot.n_u))
        )
        self._movers_input = self.DeclareAbstractInputPort(
            "movers", Value[object]()
        )
        self._motion_input = self.DeclareAbstractInputPort(
            "motion", Value[object]()
        )
        self._selection_index = self.DeclareAbstractState(
            Value(start_selection(rule))
        )
        self.DeclareStateOutputPort("selection", self._selection_index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        controller: LeafSystem,
        oracle: LeafSystem,
        **arguments,
    ) -> "GuidanceSelector":
        """Adds a selector, and connects it to a controller and its oracle.

        The caller connects `configuration` and the target.

        Args:
            builder: The builder of the diagram.
            controller: The controller that follows the selected guidance.
            oracle: The system with the map at its output `distance_field`.
            **arguments: Arguments of the constructor.

        Returns:
            The selector, which is now part of the diagram.
        """
        selector = builder.AddSystem(GuidanceSelector(**arguments))
        builder.Connect(
            controller.GetOutputPort("report"), selector.GetInputPort("report")
        )
        builder.Connect(
            oracle.GetOutputPort("distance_field"),
            selector.GetInputPort("distance_field"),
        )
        builder.Connect(
            selector.GetOutputPort("selection"),
            controller.GetInputPort("selection"),
        )
        return selector

    def _update(self, context: Context, state: State):
        cell = int(self._selection_index)
        start = perf_counter()
        selection = self._advanced(
            context, context.get_abstract_state(cell).get_value()
        )
        selection = dc.replace(selection, seconds=perf_counter() - start)
        state.get_mutable_abstract_state(cell).set_value(selection)

    def _advanced(self, context: Context, selection: Selection) -> Selection:
        report = self._report_input.Eval(context)
        now = PresentState(
            context.get_time(),
            self._configuration_input.Eval(context),
            report.command,
            self._target.read(context),
            value_or_none(self._movers_input, context),
            value_or_none(self._motion_input, context),
            report.payload,
        )
        field = self._field_input.Eval(context).for_look_ahead
        if self._process is not None:
            return updated(self._process, self._rule, selection, now, field)
        if self._budget > 0:
            return advance_selection(
                self._rule,
                selection,
                field=field,
                budget=self._budget,
                threads=self._threads,
                **vars(now),
            )
        return cycle_when_stalled(
            self._rule, selection, field=field, **vars(now)
        )


def updated(
    process: LookAheadProcess,
    rule: SelectionRule,
    selection: Selection,
    now: PresentState,
    field: DistanceField,
) -> Selection:
    """Updates a selection by the latest response of the look-ahead process.

    If the process does not respond, the function selects the candidates in
    turn, and writes the reason to `missing`.

    Args:
        process: The process that computes the rollouts.
        rule: The selector's settings.
        selection: The selection so far.
        now: The robot's present state.
        field: The map.
    """
    if not (np.isfinite(now.q).all() and now.aim.is_known):
        return selection
    held = rule.holding(now.payload)
    selection = on_the_same_world(held, selection, now.q, field, now.aim)
    selection = process.update(selection, now, field)
    if process.missing:
        selection = cycle_when_stalled(
            rule, selection, field=field, **vars(now)
        )
    return dc.replace(selection, missing=process.missing)
