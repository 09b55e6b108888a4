"""The application: every stage, wired together. The only place that does.

station --configuration--> oracle --clearances--> controller --> supervisor
--> station

`stages.py` says how each of them is made and connected.
"""

import dataclasses as dc

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.oracle.distance_oracle import DistanceOracle
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
from remosplat_drake.station.connections import (
    AddConfiguration,
    ConnectCommand,
)
from remosplat_drake.task.target_sequence import TargetSequence
from remosplat_drake.visualization.page import MeshcatPage
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

    Raises:
        RemoSplatError: The station cannot be made, or there is no target.
    """
    robot = world.robot
    builder = DiagramBuilder()
    station = builder.AddSystem(MakeStation(scenario, world, hardware))
    configuration = AddConfiguration(builder, robot, station)
    targets = AddTargets(builder, scenario, world, configuration)
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
        builder, scenario, robot, configuration, controller, executed
    )
    if page is not None:
        AddPanel(builder, page, robot, controller, supervisor, station)
        AddWorldViews(builder, page, world, configuration, controller, selector)
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
