"""Adds the stage of a task, such as picking and placing objects."""

from typing import TYPE_CHECKING

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.world import World, scene_field_maker
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.oracle_config import GroundTruth
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.station.connections import AddHandStates
from remosplat_drake.station.hand import robot_hands
from remosplat_drake.station.station_config import KinematicStation
from remosplat_drake.task.make_blocks import (
    carried_objects,
    make_blocks,
)
from remosplat_drake.task.targets import Targets
from remosplat_drake.task.task import Task, TaskState, Work
from remosplat_drake.task.task_map import StandingRule, TaskMap
from remosplat_drake.task.task_system import TaskSystem

if TYPE_CHECKING:
    from remosplat_drake.task.job_maker import JobMaker


def AddTask(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    law: ReactiveLaw,
    *,
    hardware: bool,
) -> TaskSystem:
    """Adds the system that executes the tasks of a scenario.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        law: The control law.
        hardware: Whether the station is the real robot.

    Raises:
        FieldError: A step is unusable.
    """
    maker = job_maker(scenario, world, law, hardware=hardware)
    things = {each.name: each for each in world.objects}
    for name in carried_objects(scenario.tasks):
        if name in things:
            maker.fit(things[name])
    shop = maker.workshop(world.objects)
    blocks = make_blocks(scenario.tasks, shop)
    robot, hands = world.robot, robot_hands(world.robot)
    map = task_map(scenario, world)
    task = Task(
        robot, blocks, world.objects, maker.spheres, StandingRule(law, map)
    )
    state = TaskState(task.objects, since=-np.inf)
    system = builder.AddSystem(
        TaskSystem(
            work=Work(task, state),
            map=map,
            widths={i: hand.start_width for i, hand in hands.items()},
            period=scenario.control_period,
        )
    )
    builder.Connect(configuration, system.GetInputPort("configuration"))
    return system


def job_maker(
    scenario: Scenario, world: World, law: ReactiveLaw, *, hardware: bool
) -> "JobMaker":
    """Makes the `JobMaker`, which converts requests to jobs.

    Args:
        scenario: The scenario.
        world: The content of the scenario's files.
        law: The control law.
        hardware: Whether the station is the real robot.
    """
    # Imported here, since it loads parts of scipy that other runs do not need.
    from remosplat_drake.task.job_maker import JobMaker
    from remosplat_drake.task.object_finder import ObjectFinder

    robot, guidance = world.robot, scenario.controller.guidance
    hands = robot_hands(robot).items()
    return JobMaker(
        law=law,
        planner=MotionPlanner(robot, law.self_clearance, guidance.planning),
        scene=world.scene_field or world.field,
        stopping=scenario.controller.smallest_stopping,
        q0=world.q0,
        max_widths={i: hand.max_width for i, hand in hands},
        is_stopped=hardware
        or not isinstance(scenario.station, KinematicStation),
        plans=guidance.plans,
        where=scenario.source,
        finder=ObjectFinder(
            scene_field_maker(scenario, world.seen),
            scenario.teleop.found_objects.mass,
            scenario.teleop.found_objects.largest,
            _finds_nothing(scenario, hardware=hardware),
        ),
        written=scenario.tasks,
    )


def _finds_nothing(scenario: Scenario, *, hardware: bool) -> str:
    """Returns the reason why no object can be found in the map, or ""."""
    reason = ""
    if scenario.mapping.enabled:
        reason = "a live map does not exclude it: set mapping.enabled to false"
    elif isinstance(scenario.oracle, GroundTruth):
        reason = "!GroundTruth measures no distances to the splat"
    elif not hardware and not isinstance(scenario.station, KinematicStation):
        reason = "the dynamic station has no body for it"
    if not reason:
        return ""
    return (
        "this run permits no new object, since"
        f" {reason}; or add it to the scenario's `objects`"
    )


def task_map(scenario: Scenario, world: World) -> TaskMap:
    """Makes the map of a task.

    Args:
        scenario: The scenario.
        world: The content of the scenario's files.
    """
    scene = world.scene_field or world.field
    return TaskMap(world.robot, scene, scenario.controller.smallest_stopping)


def task_port(targets: Targets, name: str) -> OutputPort | None:
    """Returns an optional port of a system of targets; None if it is missing.

    Args:
        targets: The system that outputs the targets of the end effectors.
        name: Name of the port.
    """
    return targets.GetOutputPort(name) if targets.HasOutputPort(name) else None


def ConnectTask(
    builder: DiagramBuilder,
    targets: Targets,
    robot: RobotModel,
    station: Diagram,
    velocity: OutputPort,
    executed: OutputPort,
    oracle: DistanceOracle,
    controller: ReactiveController,
) -> None:
    """Connects a task with the stages that it reads or changes.

    Args:
        builder: The builder of the diagram.
        targets: The system that outputs the targets. Nothing is connected if
            these are not the targets of a task (a `TaskSystem`).
        robot: The robot.
        station: The robot as a system, simulated or real.
        velocity: The output port of the measured u, n_u entries.
        executed: The output port of the command u that the station gets.
        oracle: The system that measures distances to the map.
        controller: The reactive controller.
    """
    if not isinstance(targets, TaskSystem):
        return
    builder.Connect(velocity, targets.GetInputPort("velocity_measured"))
    builder.Connect(executed, targets.GetInputPort("velocity_executed"))
    if robot.description.effector_hands:
        measured = AddHandStates(builder, robot, station)
        builder.Connect(measured, targets.GetInputPort("hand_state"))
    for system, names in (
        (oracle, ("distance_field", "payload")),
        (controller, ("payload", "hold")),
    ):
        for name in names:
            builder.Connect(
                targets.GetOutputPort(name), system.GetInputPort(name)
            )
