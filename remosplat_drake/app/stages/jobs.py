"""Adds the stage of an operator's jobs with objects."""

from functools import partial

from pydrake.systems.framework import DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.stages.task import job_maker, task_map
from remosplat_drake.app.world import World
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.station.hand import robot_hands
from remosplat_drake.task.job_process import JobProcess
from remosplat_drake.task.job_search import search_job
from remosplat_drake.task.task import Task
from remosplat_drake.task.task_map import StandingRule
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.operator_task import OperatorTask


def has_jobs(scenario: Scenario) -> bool:
    """Returns whether an operator may take and place the scenario's objects.

    Args:
        scenario: The scenario.
    """
    return bool(scenario.objects)


def AddOperatorTask(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    command: OutputPort,
    law: ReactiveLaw,
    target: OperatorTarget,
    scene: SceneMap | None,
    *,
    hardware: bool,
) -> OperatorTask:
    """Adds the system that executes an operator's jobs with objects.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario, with objects.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        command: The output port of the `OperatorCommand`.
        law: The control law.
        target: The target that the operator moves while there is no job.
        scene: The map without the objects; None with a live map.
        hardware: Whether the robot is real. If so, another process searches for
            grasps and places, so that ticks do not wait for the search.
    """
    maker = job_maker(scenario, world, law, hardware=hardware)
    search = partial(search_job, maker)
    if hardware:
        search = JobProcess(maker)
        search.start()
    map = task_map(scenario, world)
    return OperatorTask.AddToBuilder(
        builder,
        configuration=configuration,
        command=command,
        operator=target,
        search=search,
        task=Task(
            world.robot,
            (),
            world.objects,
            maker.spheres,
            StandingRule(law, map),
        ),
        map=map,
        scene=scene,
        widths={
            i: hand.start_width for i, hand in robot_hands(world.robot).items()
        },
        period=scenario.control_period,
    )
