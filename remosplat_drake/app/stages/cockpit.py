"""Adds the stages of the cockpit, the operator's own page."""

from collections.abc import Sequence

from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.app.control_loop import ControlLoop
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.stages.log import log_inputs
from remosplat_drake.app.stages.task import task_port
from remosplat_drake.app.stages.teleoperation import (
    Teleoperation,
    wrist_camera_mount,
)
from remosplat_drake.app.teleop_session import camera_maker
from remosplat_drake.cockpit.cockpit_operator import CockpitOperator
from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.cockpit.cockpit_view import CockpitView, picture_of
from remosplat_drake.cockpit.messages import CockpitJob, MapPicture
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.mapping.live_map import LiveMap
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.operator_target import OperatorTarget


def AddCockpitOperator(
    builder: DiagramBuilder,
    process: CockpitProcess,
    scenes: Sequence[PrimitiveScene],
) -> CockpitOperator:
    """Adds the system that outputs the operator's requests from the cockpit.

    Args:
        builder: The builder of the diagram.
        process: The process of the cockpit.
        scenes: The true scenes that a simulated camera can show; a person
            switches between them.
    """
    return builder.AddSystem(CockpitOperator(process=process, scenes=scenes))


def AddCockpitView(
    builder: DiagramBuilder,
    loop: ControlLoop,
    teleoperation: Teleoperation,
    target: OperatorTarget,
    process: CockpitProcess,
    live_map: LiveMap | None,
) -> CockpitView:
    """Adds the systems that send the robot's state to the cockpit.

    Args:
        builder: The builder of the diagram.
        loop: The control loop.
        teleoperation: The inputs of a teleoperated diagram.
        target: The target that the operator moves.
        process: The cockpit.
        live_map: The map that grows; None without a live map.
    """
    inputs = {
        **log_inputs(loop, live_map),
        "configuration": loop.configuration,
        "target_state": target.GetOutputPort("state"),
    }
    for name in ("outline", "objects", "scene_map"):
        port = task_port(loop.targets, name)
        if port is not None:
            inputs[name] = port
    return CockpitView.AddToBuilder(
        builder,
        inputs=inputs,
        process=process,
        robot=loop.world.robot,
        initial=teleoperation.first_map,
        picture=first_picture(loop, teleoperation),
        period=loop.scenario.control_period,
    )


def cockpit_job(
    loop: ControlLoop,
    teleoperation: Teleoperation,
    *,
    host: str,
    port: int | None,
    hardware: bool,
) -> CockpitJob:
    """Returns the settings that start the cockpit's process.

    Args:
        loop: The control loop.
        teleoperation: The inputs of a teleoperated diagram.
        host: Network interface that the page is served on.
        port: TCP port of the page; None means the first free port.
        hardware: Whether the robot is real.
    """
    scenario, world = loop.scenario, loop.world
    config = scenario.controller
    law = MotionLaw.make(
        scenario.teleop,
        world.robot,
        world.q0,
        scenario.control_period,
        wrist_camera_mount(scenario, world.robot),
    )
    has_camera = scenario.mapping.enabled or scenario.camera is not None
    return CockpitJob(
        title=scenario.name,
        host=host,
        port=port,
        robot=world.robot,
        planner=MotionPlanner(
            world.robot, loop.law.self_clearance, config.guidance.planning
        ),
        stopping=config.collision.stopping,
        influence=config.collision.influence,
        control_period=scenario.control_period,
        config=scenario.teleop,
        q0=world.q0,
        mapping=teleoperation.mapping is not None,
        scenes=teleoperation.scenes,
        make_camera=(
            camera_maker(scenario, world, hardware) if has_camera else None
        ),
        X_EC=law.X_EC,
        truth=world.truth if world.splat_W is None else None,
    )


def first_picture(
    loop: ControlLoop, teleoperation: Teleoperation
) -> MapPicture:
    """Returns the first map that the cockpit draws.

    Args:
        loop: The control loop.
        teleoperation: The inputs of a teleoperated diagram.
    """
    scene_map = teleoperation.first_map
    show_unseen = loop.scenario.scene.unknown == OBSTACLE
    seen = loop.world.seen
    if scene_map.coverage is not None or seen is None:
        return picture_of(scene_map, show_unseen)
    return MapPicture(
        scene_map.field,
        scene_map.splat_W,
        seen.coverage,
        show_unseen,
        seen.X_WG.GetAsMatrix4(),
    )
