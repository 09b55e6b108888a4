"""Adds the stages of a teleoperation: its target, live map and views."""

import dataclasses as dc
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from pydrake.systems.framework import (
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.app.control_loop import ControlLoop
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.resources import resolve
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.controller.map_change import objection
from remosplat_drake.detection.map_announcer import MapAnnouncer
from remosplat_drake.detection.settled_requests import SettledRequests
from remosplat_drake.mapping.live_map import LiveMap
from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.robot.robot_description import unknown_effector
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.station.hand import robot_hands
from remosplat_drake.teleop.command_merger import CommandMerger
from remosplat_drake.teleop.hand_motion import HandLaw
from remosplat_drake.teleop.lcm_operator import LcmOperator
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.operator_task import OperatorTask
from remosplat_drake.teleop.trajectory_file import load_operator_steps
from remosplat_drake.teleop.trajectory_operator import TrajectoryOperator
from remosplat_drake.visualization.live_map_view import LiveMapView
from remosplat_drake.visualization.live_plots import LivePlots
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.teleop_panel import TeleopPanel


@dc.dataclass(frozen=True, eq=False)
class Teleoperation:
    """Inputs that a teleoperated diagram needs besides its scenario.

    Attributes:
        run: Folder of the run, which gets the log of ticks and events.
        mapping: The process that takes the pictures and makes the maps; None
            without a live map.
        initial: The scenario's own map.
        reopened: The map of a continued session; None if the session has no
            map.
        scenes: True scenes that a simulated camera can show; a person switches
            between them.
        operator: A further source of requests: a system with an output port
            `command` and an optional output port `map_requests`; or None.
    """

    run: Path
    mapping: MappingProcess | None
    initial: SceneMap
    reopened: SceneMap | None = None
    scenes: tuple[PrimitiveScene, ...] = ()
    operator: LeafSystem | None = None

    @property
    def first_map(self) -> SceneMap:
        """The first map that a page draws: `reopened`, or else `initial`."""
        return self.reopened or self.initial

    @property
    def static_map(self) -> SceneMap | None:
        """The map of the whole run; None with a live map."""
        return self.initial if self.mapping is None else None

    def close(self) -> None:
        """Ends the mapping process, if there is one."""
        if self.mapping is not None:
            self.mapping.close()


def AddOperatorTarget(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    teleoperation: Teleoperation,
    page: MeshcatPage | None,
    operators: Sequence[LeafSystem] = (),
    *,
    jobs: bool = False,
) -> tuple[OperatorTarget, OutputPort]:
    """Adds the target, and all systems that may move it.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        teleoperation: The inputs of a teleoperated diagram.
        page: The browser page that gets a panel; None has none.
        operators: Operator systems that the diagram already contains.
        jobs: Whether operators may take and place objects.

    Returns:
        The target, and the output port of the merged `OperatorCommand`.

    Raises:
        RemoSplatError: The trajectory or the camera's frame is unusable, or
            a script or the stream of poses names an end effector that the
            robot does not have.
    """
    config, period = scenario.teleop, scenario.control_period
    robot, mount = world.robot, wrist_camera_mount(scenario, world.robot)
    laws = [
        MotionLaw.make(
            config, robot, world.q0, period, mount, scenario.mapping.frames, i
        )
        for i in range(len(robot.effectors))
    ]
    sources, panel, hand = list(operators), None, None
    hands = robot_hands(robot)
    if len(hands) == 1:  # An operator opens and closes the only hand.
        (only,) = hands.values()
        hand = HandLaw(only.start_width, config.grip_force)
    objects = [each.name for each in scenario.objects if jobs]
    if page is not None:
        panel = TeleopPanel.AddToBuilder(
            builder,
            page=page,
            config=config,
            X_WH=laws[0].X_WT_home,
            effectors=robot.effectors,
            mapping=teleoperation.mapping is not None,
            scenes=teleoperation.scenes,
            has_hand=hand is not None,
            objects=objects,
        )
        sources.append(panel)
    if config.trajectory:
        path = resolve(config.trajectory, scenario.folder)
        scenes = teleoperation.scenes
        steps = load_operator_steps(
            path, config.poses, scenes, robot.effectors, objects
        )
        script = TrajectoryOperator(steps=steps, scenes=scenes)
        sources.append(builder.AddSystem(script))
    if config.pose_stream is not None:
        named = config.pose_stream.effector
        if named and named not in robot.effectors:
            raise FieldError(
                scenario.source,
                "teleop.pose_stream.effector",
                unknown_effector(named, robot.effectors),
            )
        stream = LcmOperator(config=config.pose_stream, period=period)
        sources.append(builder.AddSystem(stream))
    if teleoperation.operator is not None:
        sources.append(builder.AddSystem(teleoperation.operator))
    merger = CommandMerger.AddToBuilder(builder, sources=sources, period=period)
    target = OperatorTarget.AddToBuilder(
        builder,
        configuration=configuration,
        command=merger.GetOutputPort("command"),
        map_requests=merger.GetOutputPort("map_requests"),
        robot=robot,
        q0=world.q0,
        law=laws,
        hand=hand,
    )
    if panel is not None:
        builder.Connect(
            target.GetOutputPort("state"), panel.GetInputPort("state")
        )
    return target, merger.GetOutputPort("command")


def wrist_camera_mount(
    scenario: Scenario, robot: RobotModel
) -> CameraMount | None:
    """Returns the mount of the wrist camera; None if there is no live map.

    Args:
        scenario: The scenario.
        robot: The robot.

    Raises:
        FieldError: The robot has no such frame.
    """
    if not scenario.mapping.enabled:
        return None
    camera = scenario.camera or WristCameraConfig()
    try:
        return CameraMount(robot, camera.hand_eye(), camera.frame)
    except FieldError as error:
        raise FieldError(
            scenario.source,
            error.field,
            f"{error.problem}; correct the frame, or, if the robot has no "
            "camera, set mapping.enabled to false",
        ) from error


def ConnectSupervision(
    builder: DiagramBuilder, loop: ControlLoop, target: OperatorTarget
) -> None:
    """Connects the supervisor to the operator's target and jobs.

    While the supervisor stops the robot, the target stays at the end effector,
    and jobs end.

    Args:
        builder: The builder of the diagram.
        loop: The control loop, with or without a supervisor.
        target: The target that the operator moves.
    """
    if loop.supervisor is None:
        return
    systems = [target]
    if isinstance(loop.targets, OperatorTask):
        systems.append(loop.targets)
    for system in systems:
        builder.Connect(
            loop.supervisor.GetOutputPort("supervision"),
            system.GetInputPort("supervision"),
        )


def AddLiveMap(
    builder: DiagramBuilder,
    loop: ControlLoop,
    teleoperation: Teleoperation,
    target: OperatorTarget,
    *,
    hardware: bool,
) -> LiveMap | None:
    """Adds the map that grows while the robot moves, if there is one.

    Args:
        builder: The builder of the diagram.
        loop: The control loop whose oracle uses the map.
        teleoperation: The inputs of a teleoperated diagram.
        target: The target that the operator moves.
        hardware: Whether the robot is real. If so, other programs detect
            movers, and this program sends them the version of the map in use.

    Returns:
        The live map; None if mapping is disabled.
    """
    if teleoperation.mapping is None:
        return None
    settled = AddSettledRequests(builder, loop)
    live_map = LiveMap.AddToBuilder(
        builder,
        configuration=loop.odometry,
        requests=target.GetOutputPort("map_requests"),
        settled=settled and settled.GetOutputPort("map_requests"),
        passing=settled and settled.GetOutputPort("passing"),
        oracle=loop.oracle,
        jobs=loop.targets if isinstance(loop.targets, OperatorTask) else None,
        supervisor=loop.supervisor,
        executed=loop.executed,
        objection=partial(objection, loop.law),
        localization=loop.localization,
        process=teleoperation.mapping,
        initial=teleoperation.initial,
        reopened=teleoperation.reopened,
        n_q=loop.world.robot.n_q,
        n_u=loop.world.robot.n_u,
        period=loop.scenario.control_period,
        latency=loop.scenario.mapping.latency,
        tracking=loop.localization is not None,
    )
    wire = loop.scenario.hardware
    if hardware and wire.movers is not None and not wire.shadow:
        MapAnnouncer.AddToBuilder(
            builder,
            map_status=live_map.GetOutputPort("map_status"),
            lcm=wire.open_lcm(),
            channel=wire.channels.counting_map,
        )
    return live_map


def AddSettledRequests(
    builder: DiagramBuilder, loop: ControlLoop
) -> SettledRequests | None:
    """Adds the system that requests the mapping of movers that came to rest.

    Args:
        builder: The builder of the diagram.
        loop: The control loop, which may have movers.

    Returns:
        The system; None if no movers are known.
    """
    mount = wrist_camera_mount(loop.scenario, loop.world.robot)
    if loop.known_movers is None or mount is None:
        return None
    config = loop.scenario.camera or WristCameraConfig()
    return SettledRequests.AddToBuilder(
        builder,
        configuration=loop.configuration,
        movers=loop.known_movers,
        in_view=lambda q, p_W: config.sees(mount.pose(q), p_W),
        settle=loop.scenario.detection.settle,
    )


def AddOperatorViews(
    builder: DiagramBuilder,
    loop: ControlLoop,
    teleoperation: Teleoperation,
    page: MeshcatPage,
    live_map: LiveMap | None,
) -> None:
    """Adds the views of the live map, of clearances and of velocities.

    Args:
        builder: The builder of the diagram.
        loop: The control loop.
        teleoperation: The inputs of a teleoperated diagram.
        page: The browser page to draw on.
        live_map: The map that is drawn; None without a live map.
    """
    scenario = loop.scenario
    if live_map is not None:
        LiveMapView.AddToBuilder(
            builder,
            map_status=live_map.GetOutputPort("map_status"),
            page=page,
            initial=teleoperation.first_map,
            show_unseen=scenario.scene.unknown == OBSTACLE,
        )
    config = scenario.controller
    LivePlots.AddToBuilder(
        builder,
        report=loop.report,
        executed=loop.executed,
        page=page,
        robot=loop.world.robot,
        gain=config.servo.gain,
        max_speed=config.servo.fastest,
        stopping=config.collision.stopping,
        influence=config.collision.influence,
        period=scenario.control_period,
    )
