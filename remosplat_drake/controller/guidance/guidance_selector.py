"""`GuidanceSelector`: looks ahead beside the controller, as a system."""

import dataclasses as dc
from collections.abc import Callable
from time import perf_counter

from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    State,
)

from remosplat_drake.controller.config import ReactiveControllerConfig
from remosplat_drake.controller.guidance.guidance import make_candidates
from remosplat_drake.controller.guidance.selection import (
    Selection,
    SelectionRule,
    advance_selection,
    start_selection,
)
from remosplat_drake.controller.guidance.stall_cycling import (
    cycle_when_stalled,
)
from remosplat_drake.controller.servo import PoseError
from remosplat_drake.controller.tick import ReactiveLaw
from remosplat_drake.controller.tick_report import TickReport
from remosplat_drake.robot.robot_model import RobotModel


def make_selection_rule(
    config: ReactiveControllerConfig,
    robot: RobotModel,
    arrived: Callable[[PoseError], bool],
) -> SelectionRule:
    """The selector's rule for a controller configuration.

    Rollouts run the controller's own law with a longer step, and a solver
    that is quicker with small programs. Verification is part of it: a future
    that it would stop must not count as arrival.
    """
    guidance = config.guidance
    law = ReactiveLaw.make(
        dc.replace(config, solver=guidance.solver), robot, guidance.step
    )
    candidates = make_candidates(
        [config.collision.stopping, *guidance.tiers],
        guidance.bearing,
        guidance.active_scale,
    )
    return SelectionRule(law, candidates, arrived, guidance.horizon)


class GuidanceSelector(LeafSystem):
    """Chooses how the next ticks are bent.

    .. pydrake_system::

        name: GuidanceSelector
        input_ports:
        - configuration
        - target
        - distance_field
        - report
        output_ports:
        - selection

    Every period it spends its budget of rollout steps, so that results do
    not depend on how fast the machine is. The `Selection` it hands out may
    come late without harm: safety does not rest on it.

    Args:
        rule: What is tried and when it counts as arrival.
        budget: Rollout steps a period; 0 cycles through the candidates
            whenever the robot stalls.
        period: Time between two updates [s].
    """

    def __init__(self, *, rule: SelectionRule, budget: int, period: float):
        super().__init__()
        self.set_name("guidance")
        self._rule = rule
        self._budget = budget
        robot = rule.law.robot
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self._target_input = self.DeclareAbstractInputPort(
            "target", Value(RigidTransform())
        )
        self._field_input = self.DeclareAbstractInputPort(
            "distance_field", Value[object]()
        )
        self._report_input = self.DeclareAbstractInputPort(
            "report", Value(TickReport.before_first(robot.n_q, robot.n_u))
        )
        self._selection_index = self.DeclareAbstractState(
            Value(start_selection(rule))
        )
        self.DeclareStateOutputPort("selection", self._selection_index)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._look)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        controller: LeafSystem,
        oracle: LeafSystem,
        **arguments,
    ) -> "GuidanceSelector":
        """Adds a selector and connects it to a controller and its oracle."""
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

    def _look(self, context: Context, state: State):
        cell = int(self._selection_index)
        start = perf_counter()
        selection = self._advanced(
            context, context.get_abstract_state(cell).get_value()
        )
        selection = dc.replace(selection, seconds=perf_counter() - start)
        state.get_mutable_abstract_state(cell).set_value(selection)

    def _advanced(self, context: Context, selection: Selection) -> Selection:
        now = {
            "time": context.get_time(),
            "q": self._configuration_input.Eval(context),
            "u": self._report_input.Eval(context).command,
            "X_WT": self._target_input.Eval(context).GetAsMatrix4(),
            "field": self._field_input.Eval(context),
        }
        if self._budget > 0:
            return advance_selection(
                self._rule, selection, budget=self._budget, **now
            )
        return cycle_when_stalled(self._rule, selection, **now)
