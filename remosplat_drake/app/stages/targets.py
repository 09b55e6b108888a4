"""Adds the stage that outputs the end effectors' targets."""

from typing import cast

from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.stages.task import AddTask
from remosplat_drake.app.world import World, scenario_targets
from remosplat_drake.base.errors import FieldError
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.task.targets import Targets, TargetsMaker, check_targets


def AddTargets(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    law: ReactiveLaw,
    *,
    hardware: bool = False,
) -> Targets:
    """Adds the targets of the scenario, or else the target of its true scene.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        law: The control law. A task uses it to check base poses.
        hardware: Whether the station is the real robot.

    Raises:
        RemoSplatError: There is no target, or the system that the scenario
            names outputs none.
    """
    if not isinstance(scenario.targets, list):
        return AddOwnTargets(
            builder, scenario, world, scenario.targets, configuration
        )
    robot = world.robot
    if scenario.tasks:
        return AddTask(
            builder, scenario, world, configuration, law, hardware=hardware
        )
    listed = scenario_targets(scenario, world.truth, robot.effectors)
    if not any(listed.values()):
        raise FieldError(
            scenario.source,
            "targets",
            "none given: list targets here, or use a `scene.truth` that has"
            " a target",
        )
    return TargetSequence.AddToBuilder(
        builder,
        configuration=configuration,
        robot=robot,
        X_WTs=listed,
        arrival=scenario.arrival,
        period=scenario.control_period,
    )


def AddOwnTargets(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    maker: TargetsMaker,
    configuration: OutputPort,
) -> Targets:
    """Adds a user's own system that outputs targets.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        maker: The settings that make the system of the targets.
        configuration: The output port of the measured q, n_q entries.

    Raises:
        RemoSplatError: The system has no output of targets.
    """
    targets = maker.make(world.robot, scenario.arrival, scenario.control_period)
    check_targets(targets, f"{scenario.source}: {type(maker).__name__}")
    builder.AddSystem(cast(LeafSystem, targets))
    builder.Connect(configuration, targets.GetInputPort("configuration"))
    return targets
