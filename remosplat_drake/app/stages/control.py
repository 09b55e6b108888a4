"""Adds the stages that compute the command: oracle, controller, guidance."""

import math
from collections.abc import Callable
from functools import partial

from pydrake.systems.framework import DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.world import World
from remosplat_drake.controller.guidance.guidance_selector import (
    GuidanceSelector,
)
from remosplat_drake.controller.guidance.look_ahead_process import (
    LookAheadProcess,
)
from remosplat_drake.controller.guidance.selection_rule import (
    make_selection_rule,
)
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.rest import RestRule
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.target_ports import connect_target
from remosplat_drake.task.arrival import has_arrived
from remosplat_drake.task.targets import Targets, target_port


def AddOracle(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
) -> DistanceOracle:
    """Adds the oracle that measures distances to the map.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files, including the map.
        configuration: The output port of the measured q, n_q entries.
    """
    return DistanceOracle.AddToBuilder(
        builder,
        robot=world.robot,
        field=world.field,
        max_distance=scenario.controller.collision.influence,
        configuration=configuration,
    )


def AddController(
    builder: DiagramBuilder,
    law: ReactiveLaw,
    configuration: OutputPort,
    targets: Targets,
    oracle: DistanceOracle,
    rest: RestRule | None = None,
) -> ReactiveController:
    """Adds the reactive controller, which ticks at the law's period.

    Args:
        builder: The builder of the diagram.
        law: The control law.
        configuration: The output port of the measured q, n_q entries.
        targets: The system that outputs the targets of the end effectors.
        oracle: The system that measures distances to the map.
        rest: Condition under which a robot stands still at a reached target. If
            None, it never stands still.
    """
    return ReactiveController.AddToBuilder(
        builder,
        law=law,
        oracle=oracle,
        configuration=configuration,
        target=target_port(targets),
        rest=rest,
    )


def arrival_of(scenario: Scenario) -> Callable[[PoseError], bool]:
    """Returns a function that decides whether a pose error is an arrival."""
    return partial(has_arrived, config=scenario.arrival)


def AddGuidance(
    builder: DiagramBuilder,
    scenario: Scenario,
    law: ReactiveLaw,
    configuration: OutputPort,
    targets: Targets,
    oracle: DistanceOracle,
    controller: ReactiveController,
) -> GuidanceSelector | None:
    """Adds guidance beside the controller, if the scenario enables it.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        law: The controller's control law. The law of the rollouts is derived
            from it.
        configuration: The output port of the measured q, n_q entries.
        targets: The system that outputs the targets of the end effectors.
        oracle: The system that outputs the map.
        controller: The controller, which receives guidance's selection.

    Returns:
        The selector; None without guidance.
    """
    config = scenario.controller.guidance
    if not config.enabled:
        return None
    rule = make_selection_rule(law, config, arrival_of(scenario))
    process, period = None, law.dt
    if config.asynchronous:
        budget = 1e-3 * config.budget_ms
        process = LookAheadProcess(rule, budget, oracle.field.for_look_ahead)
        # The rollouts of a request take the whole time budget, so more frequent
        # requests would only cost time.
        period *= math.ceil(budget / period)
    selector = GuidanceSelector.AddToBuilder(
        builder,
        controller=controller,
        oracle=oracle,
        rule=rule,
        budget=config.budget,
        period=period,
        process=process,
    )
    builder.Connect(configuration, selector.GetInputPort("configuration"))
    connect_target(builder, target_port(targets), selector)
    return selector
