"""The application: every stage, wired together. The only place that does.

station --configuration--> oracle --clearances--> controller --> supervisor
--> station
"""

import dataclasses as dc
import math
from functools import partial

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    OutputPort,
)
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    Multiplexer,
)

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
from remosplat_drake.controller.tick import ReactiveLaw
from remosplat_drake.errors import FieldError, RemoSplatError
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervision import SupervisorLaw
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.scenario import Scenario, make_transform
from remosplat_drake.station import ports
from remosplat_drake.station.simulated_station import MakeHardwareStation
from remosplat_drake.task.arrival import has_arrived
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.safety_panel import SafetyPanel
from remosplat_drake.visualization.views import AddViews
from remosplat_drake.world import World


@dc.dataclass(frozen=True, eq=False)
class Application:
    """A built diagram and the parts that a run looks at."""

    scenario: Scenario
    world: World
    diagram: Diagram
    station: Diagram
    oracle: DistanceOracle
    controller: ReactiveController
    supervisor: SafetySupervisor | None
    targets: TargetSequence
    recorder: TrajectoryRecorder
    configuration: OutputPort


def MakeDiagram(
    scenario: Scenario,
    world: World,
    page: MeshcatPage | None = None,
    *,
    hardware: bool = False,
) -> Application:
    """Wires a scenario's stages into one diagram.

    Args:
        scenario: The experiment.
        world: What its files hold.
        page: A browser page to draw on.
        hardware: Whether the station is the real robot; nothing else differs.
    """
    robot, dt = world.robot, scenario.control_period
    builder = DiagramBuilder()
    station = builder.AddSystem(_MakeStation(scenario, world, hardware))
    configuration = _AddMeasured(
        builder,
        "configuration",
        robot,
        station,
        [ports.BASE_POSE, ports.arm_position(robot.description)],
    )
    targets = TargetSequence.AddToBuilder(
        builder,
        configuration=configuration,
        robot=robot,
        X_WTs=_targets(scenario, world),
        arrival=scenario.arrival,
        period=dt,
    )
    oracle = DistanceOracle.AddToBuilder(
        builder,
        robot=robot,
        field=world.field,
        max_distance=scenario.controller.collision.influence,
        configuration=configuration,
    )
    controller = ReactiveController.AddToBuilder(
        builder,
        law=ReactiveLaw.make(scenario.controller, robot, dt),
        oracle=oracle,
    )
    builder.Connect(configuration, controller.GetInputPort("configuration"))
    builder.Connect(
        targets.GetOutputPort("target"), controller.GetInputPort("target")
    )
    selector = None
    if scenario.controller.guidance.enabled:
        selector = _AddGuidance(
            builder, scenario, robot, controller, oracle, targets, configuration
        )
    supervisor = None
    commander = controller
    if scenario.supervisor.enabled:
        supervisor = _AddSupervisor(
            builder, scenario, robot, controller, station
        )
        commander = supervisor
    executed = commander.GetOutputPort("velocity_commanded")
    _ConnectCommand(builder, robot, executed, station)
    report = controller.GetOutputPort("report")
    recorder = TrajectoryRecorder.AddToBuilder(
        builder,
        configuration=configuration,
        report=report,
        executed=executed,
        n_q=robot.n_q,
        n_u=robot.n_u,
        period=dt,
    )
    if page is not None and supervisor is not None:
        SafetyPanel.AddToBuilder(
            builder,
            page=page,
            n_u=robot.n_u,
            supervisor=supervisor,
            report=report,
            status=station.GetOutputPort(ports.STATUS),
        )
    if page is not None:
        AddViews(
            builder,
            page,
            robot=robot,
            splat_W=world.splat_W,
            truth=world.truth,
            configuration=configuration,
            report=report,
            selection=selector and selector.GetOutputPort("selection"),
        )
    diagram = builder.Build()
    diagram.set_name("remosplat")
    return Application(
        scenario,
        world,
        diagram,
        station,
        oracle,
        controller,
        supervisor,
        targets,
        recorder,
        configuration,
    )


def _AddGuidance(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    controller: ReactiveController,
    oracle: DistanceOracle,
    targets: TargetSequence,
    configuration: OutputPort,
) -> GuidanceSelector:
    """Adds the look-ahead beside the controller."""
    config = scenario.controller
    arrived = partial(has_arrived, config=scenario.arrival)
    process = None
    if config.guidance.asynchronous:
        process = LookAheadProcess(config, robot, arrived)
    selector = GuidanceSelector.AddToBuilder(
        builder,
        controller=controller,
        oracle=oracle,
        rule=make_selection_rule(config, robot, arrived),
        budget=config.guidance.budget,
        period=scenario.control_period,
        process=process,
    )
    builder.Connect(configuration, selector.GetInputPort("configuration"))
    builder.Connect(
        targets.GetOutputPort("target"), selector.GetInputPort("target")
    )
    return selector


def _AddSupervisor(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    controller: ReactiveController,
    station: Diagram,
) -> SafetySupervisor:
    """Adds the supervisor between controller and station."""
    config = scenario.controller
    tiers = config.guidance.tiers if config.guidance.enabled else []
    supervisor = SafetySupervisor.AddToBuilder(
        builder,
        law=SupervisorLaw.make(
            scenario.supervisor,
            robot,
            scenario.control_period,
            smallest_stopping=min([config.collision.stopping, *tiers]),
            bounded_start=config.velocity_limits.acceleration,
        ),
        controller=controller,
    )
    measured = _AddMeasured(
        builder,
        "velocity_measured",
        robot,
        station,
        [ports.BASE_VELOCITY, ports.arm_velocity(robot.description)],
    )
    builder.Connect(measured, supervisor.GetInputPort("velocity_measured"))
    builder.Connect(
        station.GetOutputPort(ports.STATUS), supervisor.GetInputPort("status")
    )
    return supervisor


def _MakeStation(scenario: Scenario, world: World, hardware: bool) -> Diagram:
    try:
        return MakeHardwareStation(
            config=scenario.station,
            robot=world.robot,
            scene=world.truth,
            q0=world.q0,
            wrist_camera=scenario.wrist_camera,
            hardware=scenario.hardware if hardware else None,
        )
    except RemoSplatError as error:
        raise RemoSplatError(f"{scenario.source}: {error}") from error


def _targets(scenario: Scenario, world: World):
    targets = [
        make_transform(target, scenario.source, f"targets[{i}]")
        for i, target in enumerate(scenario.targets)
    ]
    if not targets and world.truth is not None and world.truth.X_WE_target:
        targets = [world.truth.X_WE_target]
    if not targets:
        raise FieldError(
            scenario.source, "targets", "none given, here or in scene.truth"
        )
    return targets


def _AddMeasured(
    builder: DiagramBuilder,
    name: str,
    robot: RobotModel,
    station: Diagram,
    base_and_arm: list[str],
) -> OutputPort:
    """Stacks two of the station's measurements, or the arm's alone."""
    names = base_and_arm if robot.n_base else base_and_arm[1:]
    measured = [station.GetOutputPort(n) for n in names]
    multiplexer = builder.AddNamedSystem(
        name, Multiplexer([port.size() for port in measured])
    )
    for i, port in enumerate(measured):
        builder.Connect(port, multiplexer.get_input_port(i))
    return multiplexer.get_output_port()


def _ConnectCommand(
    builder: DiagramBuilder,
    robot: RobotModel,
    velocity: OutputPort,
    station: Diagram,
) -> None:
    """Splits the command u between base and arm; holds the gripper open."""
    description = robot.description
    names = [ports.arm_command(description)]
    if robot.n_base:
        names.insert(0, ports.BASE_COMMAND)
    inputs = [station.GetInputPort(name) for name in names]
    demultiplexer = builder.AddNamedSystem(
        "command", Demultiplexer([port.size() for port in inputs])
    )
    builder.Connect(velocity, demultiplexer.get_input_port())
    for i, port in enumerate(inputs):
        builder.Connect(demultiplexer.get_output_port(i), port)
    if description.hand:
        open_width = math.fsum(
            description.locked.get(joint, 0.0)
            for joint in description.hand.joints
        )
        hand = builder.AddNamedSystem(
            "hand_command", ConstantVectorSource([open_width, 20.0])
        )
        builder.Connect(
            hand.get_output_port(),
            station.GetInputPort(ports.hand_command(description)),
        )
