"""Adds the stage of a task, such as picking and placing objects."""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.world import World
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.robot.reach import end_effector_reach, shoulder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.station.connections import AddHandStates
from remosplat_drake.station.hand import robot_hands
from remosplat_drake.station.station_config import KinematicStation
from remosplat_drake.task.make_blocks import (
    carried_objects,
    make_blocks,
)
from remosplat_drake.task.targets import Targets
from remosplat_drake.task.task import Task
from remosplat_drake.task.task_map import StandingRule, TaskMap
from remosplat_drake.task.task_system import TaskSystem
from remosplat_drake.task.workshop import Workshop


def AddTask(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    law: ReactiveLaw,
    *,
    hardware: bool,
) -> TaskSystem:
    """Adds the system that leads the robot through the tasks of a scenario.

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
    # Imported here, since it loads parts of scipy that other runs do not need.
    from remosplat_drake.task.free_places import Surroundings, free_places
    from remosplat_drake.task.object_spheres import fit_object, overhang

    robot, hands = world.robot, robot_hands(world.robot)
    names = tuple(each.name for each in world.objects)
    things = {each.name: each for each in world.objects}
    carried = [x for x in carried_objects(scenario.tasks) if x in things]
    spheres = {name: fit_object(things[name]) for name in carried}
    scene = world.scene_field or world.field
    stopping = scenario.controller.smallest_stopping

    def places(
        name: str, support: str, near: Sequence[float] | None, effector: int
    ) -> list[RigidTransform]:
        others = [x for x in world.objects if x.name not in (name, support)]
        p_WA, reach = None, np.inf
        if not robot.n_base:
            p_WA = shoulder(robot, world.q0, effector)
            reach = end_effector_reach(robot, effector)
        field = with_objects(scene, ObjectField(others))
        return free_places(
            things[name],
            spheres[name],
            things[support],
            Surroundings(field, stopping, p_WA, reach),
            None if near is None else np.array(near),
        )

    shop = Workshop(
        robot,
        names,
        {name: overhang(things[name], spheres[name]) for name in carried},
        {i: hand.max_width for i, hand in hands.items()},
        hardware or not isinstance(scenario.station, KinematicStation),
        scenario.source,
        scenario.controller.guidance.plans,
        places,
    )
    blocks = make_blocks(scenario.tasks, shop)
    map = TaskMap(robot, scene, stopping)
    task = Task(robot, blocks, world.objects, spheres, StandingRule(law, map))
    system = builder.AddSystem(
        TaskSystem(
            task=task,
            map=map,
            widths={i: hand.start_width for i, hand in hands.items()},
            period=scenario.control_period,
        )
    )
    builder.Connect(configuration, system.GetInputPort("configuration"))
    return system


def task_port(targets: Targets, name: str) -> OutputPort | None:
    """Returns a port that only some systems of targets have; None without it.

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
    """Connects a task with the stages that it reads, and that it changes.

    Args:
        builder: The builder of the diagram.
        targets: The system that outputs the targets. If it does not lead
            through a task, nothing is connected.
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
