"""The application: every stage, wired together. The only place that does.

station --configuration--> oracle --clearances--> controller --> supervisor
--> station

`stages.py` says how each of them is made and connected.
"""

import dataclasses as dc

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.mapping.live_map import LiveMap
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.recording.session_log import TrajectoryLog
from remosplat_drake.recording.trajectory_recorder import TrajectoryRecorder
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.scenario import Scenario
from remosplat_drake.stages import (
    AddController,
    AddGuidance,
    AddOracle,
    AddPanel,
    AddRecorder,
    AddSupervisor,
    AddTargets,
    AddWorldViews,
    MakeStation,
)
from remosplat_drake.station import ports
from remosplat_drake.station.connections import (
    AddConfiguration,
    ConnectCommand,
)
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop_stages import (
    AddLiveMap,
    AddLog,
    AddOperatorTarget,
    AddOperatorViews,
    ConnectSupervision,
    Teleoperation,
)
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.world import World

KEPT = 10.0
"""So much of a teleoperation stays in memory; all of it is in its log [s]."""


@dc.dataclass(frozen=True, eq=False)
class Application:
    """A built diagram and the parts that a run looks at.

    A teleoperated one has a log, and a live map if its scenario wants that.
    """

    scenario: Scenario
    world: World
    diagram: Diagram
    station: Diagram
    oracle: DistanceOracle
    controller: ReactiveController
    supervisor: SafetySupervisor | None
    targets: TargetSequence | OperatorTarget
    recorder: TrajectoryRecorder
    configuration: OutputPort
    live_map: LiveMap | None = None
    log: TrajectoryLog | None = None


def MakeDiagram(
    scenario: Scenario,
    world: World,
    page: MeshcatPage | None = None,
    *,
    hardware: bool = False,
    teleoperation: Teleoperation | None = None,
) -> Application:
    """Wires a scenario's stages into one diagram.

    Args:
        scenario: The experiment.
        world: What its files hold.
        page: A browser page to draw on.
        hardware: Whether the station is the real robot; nothing else differs.
        teleoperation: An operator moves the target, and the map may grow.

    Raises:
        RemoSplatError: The station cannot be made, or there is no target.
    """
    robot = world.robot
    builder = DiagramBuilder()
    panel = AddPanel(builder, scenario, robot, page)
    station = builder.AddSystem(MakeStation(scenario, world, hardware))
    configuration = AddConfiguration(builder, robot, station)
    if teleoperation is None:
        targets = AddTargets(builder, scenario, world, configuration)
    else:
        targets = AddOperatorTarget(
            builder, scenario, world, configuration, teleoperation, page
        )
    oracle = AddOracle(builder, scenario, world, configuration)
    controller = AddController(
        builder, scenario, robot, configuration, targets, oracle
    )
    selector = AddGuidance(
        builder, scenario, robot, configuration, targets, oracle, controller
    )
    supervisor = AddSupervisor(builder, scenario, robot, controller, station)
    commander = controller if supervisor is None else supervisor
    executed = commander.GetOutputPort("velocity_commanded")
    ConnectCommand(builder, robot, executed, station)
    recorder = AddRecorder(
        builder,
        scenario,
        robot,
        configuration,
        controller,
        executed,
        keep=None if teleoperation is None else KEPT,
    )
    live_map = log = None
    if teleoperation is not None:
        ConnectSupervision(builder, supervisor, targets)
        live_map = AddLiveMap(
            builder,
            scenario,
            world,
            configuration,
            teleoperation,
            targets,
            oracle,
            supervisor,
        )
        log = AddLog(
            builder,
            scenario,
            world,
            teleoperation,
            controller,
            executed,
            supervisor,
            targets,
            live_map,
        )
    if panel is not None and supervisor is not None:
        panel.ConnectTo(
            builder,
            supervisor=supervisor,
            report=controller.GetOutputPort("report"),
            status=station.GetOutputPort(ports.STATUS),
        )
    if page is not None:
        AddWorldViews(
            builder, page, world, configuration, controller, selector, live_map
        )
        if teleoperation is not None and log is not None:
            AddOperatorViews(
                builder,
                scenario,
                world,
                teleoperation,
                page,
                controller,
                executed,
                live_map,
                log,
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
        live_map,
        log,
    )
