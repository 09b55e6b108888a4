"""How each stage of the application is made from a scenario.

`diagram.py` wires them together; what a stage needs from others are its
arguments.
"""

import math
from functools import partial
from typing import cast

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.app.other_robot_config import OtherRobot
from remosplat_drake.app.scenario import TRUTH, Scenario
from remosplat_drake.app.world import World, scenario_targets
from remosplat_drake.base.errors import FieldError, RemoSplatError
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
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.mapping.localization.base_localization import (
    BaseLocalization,
)
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervision import SupervisorLaw
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.scene.moving.track import Track, movers_at
from remosplat_drake.sight.known_scene import KnownScene, surface_points
from remosplat_drake.sight.simulated.camera_sight import (
    CameraSight,
    simulated_sight,
)
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.target_ports import connect_target
from remosplat_drake.standing.standing_system import StandingSystem
from remosplat_drake.station.base_uncertainty import BaseUncertainty
from remosplat_drake.station.connections import AddMeasuredVelocity
from remosplat_drake.station.mover_sensing import KnownMovers
from remosplat_drake.station.mover_sensor_system import MoverSensorSystem
from remosplat_drake.station.mover_source import MoverSource
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.task.arrival import has_arrived
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.task.targets import (
    Targets,
    TargetsMaker,
    check_targets,
    target_port,
)
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.safety_panel import SafetyPanel


def MakeStation(scenario: Scenario, world: World, hardware: bool) -> Diagram:
    """Makes the station of a scenario, simulated or real.

    Args:
        scenario: The scenario.
        world: What the scenario's files hold.
        hardware: Whether the station is the real robot.

    Raises:
        RemoSplatError: The station cannot be made; the text names the
            scenario.
    """
    camera = scenario.camera
    try:
        if hardware:
            return HardwareStation(
                config=scenario.hardware,
                robot=world.robot,
                wrist_camera=camera is not None,
            )
        return MakeSimulatedStation(
            config=scenario.station,
            robot=world.robot,
            scene=world.truth,
            q0=world.q0,
            wrist_camera=camera,
            movers=list(movers_at(tracks_of(scenario), 0.0)),
        )
    except RemoSplatError as error:
        raise RemoSplatError(f"{scenario.source}: {error}") from error


def AddLocalization(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    odometry: OutputPort,
) -> BaseLocalization | None:
    """Adds what corrects a mobile base's odometry by the live map.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot.
        odometry: The output port of the measured q, n_q entries.

    Returns:
        None where the base is fixed or its odometry is trusted.
    """
    if not robot.n_base or not scenario.mapping.corrects_base:
        return None
    return BaseLocalization.AddToBuilder(
        builder,
        odometry,
        n_q=robot.n_q,
        period=scenario.control_period,
        speed=scenario.mapping.correction_speed,
    )


def AddTargets(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
) -> Targets:
    """Adds the targets of the scenario, or else the target of its true scene.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: What the scenario's files hold.
        configuration: The output port of the measured q, n_q entries.

    Raises:
        RemoSplatError: There is no target, or the system that the scenario
            names hands out none.
    """
    if not isinstance(scenario.targets, list):
        return AddOwnTargets(
            builder, scenario, world, scenario.targets, configuration
        )
    listed = scenario_targets(scenario, world.truth)
    if not listed:
        raise FieldError(
            scenario.source, "targets", "none given, here or in scene.truth"
        )
    return TargetSequence.AddToBuilder(
        builder,
        configuration=configuration,
        robot=world.robot,
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
    """Adds targets from outside the library.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: What the scenario's files hold.
        maker: The settings that make the system of the targets.
        configuration: The output port of the measured q, n_q entries.

    Raises:
        RemoSplatError: The system that is made hands out no targets.
    """
    targets = maker.make(world.robot, scenario.arrival, scenario.control_period)
    check_targets(targets, f"{scenario.source}: {type(maker).__name__}")
    builder.AddSystem(cast(LeafSystem, targets))
    builder.Connect(configuration, targets.GetInputPort("configuration"))
    return targets


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
        world: What the scenario's files hold, the map among them.
        configuration: The output port of the measured q, n_q entries.
    """
    return DistanceOracle.AddToBuilder(
        builder,
        robot=world.robot,
        field=world.field,
        max_distance=scenario.controller.collision.influence,
        configuration=configuration,
    )


def ConnectUncertainty(
    builder: DiagramBuilder,
    station: Diagram,
    localization: BaseLocalization | None,
    oracle: DistanceOracle,
) -> None:
    """Tells the oracle how far the base's pose may be off.

    Args:
        builder: The builder of the diagram.
        station: The robot, simulated or real, as a system.
        localization: What corrects the base by the live map, if anything.
        oracle: The system that measures distances to the map.
    """
    uncertainty = BaseUncertainty.AddToBuilder(builder, station)
    name = "base_uncertainty"
    if localization is not None:
        builder.Connect(uncertainty, localization.GetInputPort(name))
        uncertainty = localization.GetOutputPort(name)
    builder.Connect(uncertainty, oracle.GetInputPort(name))


def AddController(
    builder: DiagramBuilder,
    law: ReactiveLaw,
    configuration: OutputPort,
    targets: Targets,
    oracle: DistanceOracle,
) -> ReactiveController:
    """Adds the reactive controller, which ticks at the law's period.

    Args:
        builder: The builder of the diagram.
        law: The control law.
        configuration: The output port of the measured q, n_q entries.
        targets: The system that says where the end effector shall go.
        oracle: The system that measures distances to the map.
    """
    return ReactiveController.AddToBuilder(
        builder,
        law=law,
        oracle=oracle,
        configuration=configuration,
        target=target_port(targets),
    )


def AddGuidance(
    builder: DiagramBuilder,
    scenario: Scenario,
    law: ReactiveLaw,
    configuration: OutputPort,
    targets: Targets,
    oracle: DistanceOracle,
    controller: ReactiveController,
) -> GuidanceSelector | None:
    """Adds the look-ahead beside the controller, if the scenario wants it.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        law: The control law of the controller, from which that of the
            rollouts is derived.
        configuration: The output port of the measured q, n_q entries.
        targets: The system that says where the end effector shall go.
        oracle: The system that hands out the map.
        controller: The controller whose ticks are bent.

    Returns:
        The selector; None without guidance.
    """
    config = scenario.controller.guidance
    if not config.enabled:
        return None
    arrived = partial(has_arrived, config=scenario.arrival)
    rule = make_selection_rule(law, config, arrived)
    process, period = None, law.dt
    if config.asynchronous:
        budget = 1e-3 * config.budget_ms
        process = LookAheadProcess(rule, budget)
        # To ask more often than it answers would only cost time.
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


def AddMovers(
    builder: DiagramBuilder,
    scenario: Scenario,
    station: Diagram,
    *,
    hardware: bool,
) -> OutputPort | None:
    """Adds what moves in simulation, or what is heard of it.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        station: The robot, simulated or real, as a system.
        hardware: Whether the station is the real robot.

    Returns:
        The output port of the `Movers`; None where nothing is known to move.
    """
    if station.HasOutputPort(ports.MOVERS):
        return station.GetOutputPort(ports.MOVERS)
    tracks = tracks_of(scenario)
    if hardware or not tracks:
        return None
    source = builder.AddSystem(MoverSource(tracks=tracks))
    movers = source.GetOutputPort("movers")
    if station.HasInputPort(ports.MOVERS):
        builder.Connect(movers, station.GetInputPort(ports.MOVERS))
    return movers


def tracks_of(scenario: Scenario) -> list[Track]:
    """Returns how a scenario's movers move, but for other robots.

    Args:
        scenario: The scenario.

    Raises:
        RemoSplatError: A file that a mover names cannot be used.
    """
    makers = [m for m in scenario.movers if not isinstance(m, OtherRobot)]
    return [maker.make(scenario.folder) for maker in makers]


def AddMoverSensor(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    oracle: DistanceOracle,
    truth: OutputPort | None,
) -> OutputPort | None:
    """Adds what the robot of a simulation gets to know of what moves.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: What the scenario's files hold.
        configuration: The output port of the measured q, n_q entries.
        oracle: The system that hands out the map, which cameras know.
        truth: The output port of the true `Movers`; None where nothing moves.

    Returns:
        The output port of the known `Movers`; None where nothing is ever
        known.
    """
    if truth is None:
        return None
    if scenario.movers_from != TRUTH:
        return AddCameraSight(
            builder, scenario, world, configuration, oracle, truth
        )
    if isinstance(scenario.mover_sensing, KnownMovers):
        return truth
    sensor = scenario.mover_sensing.make(world.robot, world.truth)
    if sensor is None:
        return None
    return MoverSensorSystem.AddToBuilder(
        builder, sensor=sensor, truth=truth, configuration=configuration
    )


def AddCameraSight(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    oracle: DistanceOracle,
    truth: OutputPort,
) -> OutputPort:
    """Adds the simulated cameras that watch for what moves.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: What the scenario's files hold.
        configuration: The output port of the measured q, n_q entries.
        oracle: The system that hands out the map.
        truth: The output port of the true `Movers`.

    Returns:
        The output port of the `Movers` that they see.
    """
    sight = CameraSight.AddToBuilder(
        builder,
        sight=simulated_sight(
            scenario.cameras,
            world.robot,
            world.truth,
            known_scene(scenario, world),
            scenario.sight,
            scenario.seed,
        ),
        configuration=configuration,
        truth=truth,
        distance_field=oracle.GetOutputPort("distance_field"),
        period=scenario.control_period,
    )
    return sight.GetOutputPort("movers")


def known_scene(scenario: Scenario, world: World) -> KnownScene:
    """Makes what cameras that watch for movers know of the scene.

    Args:
        scenario: The scenario.
        world: What its files hold.
    """
    surface_W = surface_points(world.splat_W, None)
    if not len(surface_W):
        surface_W = surface_points(None, world.truth)
    return KnownScene(world.field, scenario.sight, surface_W)


def AddSupervisor(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    controller: ReactiveController,
    station: Diagram,
    *,
    armed: bool = True,
) -> SafetySupervisor | None:
    """Adds the supervisor between controller and station, if wanted.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot, for its limits.
        controller: The controller whose commands are supervised.
        station: The robot, simulated or real, as a system.
        armed: Whether the robot may start without an operator's consent.

    Returns:
        The supervisor; None if the scenario wants none.
    """
    if not scenario.supervisor.enabled:
        return None
    config = scenario.controller
    law = SupervisorLaw.make(
        scenario.supervisor,
        robot,
        scenario.control_period,
        smallest_stopping=config.smallest_stopping,
        bounded_start=config.velocity_limits.acceleration,
        strict=config.velocity_limits.strict,
        obeyed=not scenario.hardware.shadow,
    )
    supervisor = SafetySupervisor.AddToBuilder(
        builder,
        law=law,
        controller=controller,
        armed=armed,
    )
    builder.Connect(
        AddMeasuredVelocity(builder, robot, station),
        supervisor.GetInputPort("velocity_measured"),
    )
    builder.Connect(
        station.GetOutputPort(ports.STATUS), supervisor.GetInputPort("status")
    )
    return supervisor


def AddStanding(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    targets: Targets,
    oracle: DistanceOracle,
    controller: ReactiveController,
    selector: GuidanceSelector | None,
    supervisor: SafetySupervisor | None,
) -> StandingSystem:
    """Adds what says in one sentence how things stand with the robot.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: What the scenario's files hold.
        configuration: The output port of the measured q, n_q entries.
        targets: The system that says where the end effector shall go.
        oracle: The system that hands out the map.
        controller: The controller whose reports are put into words.
        selector: The look-ahead beside the controller; None without one.
        supervisor: The safety supervisor; None without one.
    """
    inputs = {
        "configuration": configuration,
        "report": controller.GetOutputPort("report"),
        "distance_field": oracle.GetOutputPort("distance_field"),
    }
    if targets.HasOutputPort("progress"):
        inputs["progress"] = targets.GetOutputPort("progress")
    if selector is not None:
        inputs["selection"] = selector.GetOutputPort("selection")
    if supervisor is not None:
        inputs["supervision"] = supervisor.GetOutputPort("supervision")
    truth = world.truth
    return StandingSystem.AddToBuilder(
        builder,
        inputs=inputs,
        robot=world.robot,
        arrival=scenario.arrival,
        period=scenario.control_period,
        floor_height=scenario.scene.floor_height,
        truth=None if truth is None else SignedDistanceField(truth),
    )


def AddRecorder(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    configuration: OutputPort,
    controller: ReactiveController,
    executed: OutputPort,
    movers: OutputPort | None = None,
    keep: float | None = None,
) -> TrajectoryRecorder:
    """Adds the recorder of configurations, tick reports and commands.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot, for the lengths of q and u.
        configuration: The output port of the measured q, n_q entries.
        controller: The controller whose reports are kept.
        executed: The output port of the command u that the station gets.
        movers: The output port of the `Movers`; None where nothing moves.
        keep: Age at which reports are forgotten, for runs without an end [s];
            None keeps all.
    """
    return TrajectoryRecorder.AddToBuilder(
        builder,
        configuration=configuration,
        report=controller.GetOutputPort("report"),
        executed=executed,
        movers=movers,
        n_q=robot.n_q,
        n_u=robot.n_u,
        period=scenario.control_period,
        keep=keep,
    )


def AddPanel(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    page: MeshcatPage | None,
    *,
    hardware: bool = False,
) -> SafetyPanel | None:
    """Adds the stop button, if there is a supervisor to obey it.

    It comes before everything else that has controls on the page, so that it
    is on top of them.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot, for the length of u.
        page: The browser page; None has no button.
        hardware: Whether a real robot moves: no page may set it going.

    Returns:
        The panel; None without a page or a supervisor.
    """
    if page is None or not scenario.supervisor.enabled:
        return None
    return builder.AddSystem(
        SafetyPanel(page=page, n_u=robot.n_u, releases=not hardware)
    )
