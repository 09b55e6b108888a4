"""`ControlLoop`: the stages that drive the robot, in a closed loop.

station --configuration--> oracle --clearances--> controller --> supervisor
--> station

All other parts of the application observe the loop or add to it.
"""

import dataclasses as dc
from collections.abc import Callable, Sequence
from functools import partial

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.stages.control import (
    AddController,
    AddGuidance,
    AddOracle,
    arrival_of,
)
from remosplat_drake.app.stages.movers import AddMovers, AddMoverSensor
from remosplat_drake.app.stages.prediction import (
    AddActuators,
    AddPrediction,
    ConnectPrediction,
)
from remosplat_drake.app.stages.records import AddMotionStatus
from remosplat_drake.app.stages.station import (
    AddLocalization,
    ConnectUncertainty,
    MakeStation,
)
from remosplat_drake.app.stages.supervision import AddSupervisor
from remosplat_drake.app.stages.task import ConnectTask, task_port
from remosplat_drake.app.world import World
from remosplat_drake.controller.guidance.guidance_selector import (
    GuidanceSelector,
)
from remosplat_drake.controller.prediction.motion_predictor import (
    MotionPredictor,
)
from remosplat_drake.controller.program.ingredient import Ingredient
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.rest import RestRule
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.mapping.localization.base_localization import (
    BaseLocalization,
)
from remosplat_drake.motion_status.motion_status_system import (
    MotionStatusSystem,
)
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.connections import (
    AddConfiguration,
    AddMeasuredVelocity,
    ConnectCommand,
)
from remosplat_drake.task.targets import Targets


@dc.dataclass(frozen=True, eq=False)
class ControlLoop:
    """The stages of a closed loop.

    Attributes:
        scenario: The scenario that the stages are made from.
        world: The content of the scenario's files: robot, map and true scene.
        station: The robot, simulated or real, as a system.
        odometry: The output port of the configuration q that the station
            measures, n_q entries.
        velocity: The output port of the measured u, n_u entries.
        localization: The system that corrects the base's pose by comparison
            with the map; None if the odometry is not corrected.
        configuration: The output port of the configuration q in W, n_q entries.
        targets: The system that outputs the targets of the end effectors.
        oracle: The system that measures distances to the map.
        law: The control law.
        controller: The reactive controller.
        selector: The guidance selector, which runs rollouts beside the
            controller; None if the scenario disables guidance.
        supervisor: The safety supervisor between controller and station; None
            if the scenario disables it.
        motion_status: The system that describes the robot's state in one
            sentence.
        known_movers: The output port of the moving obstacles (`Movers`) that
            the robot perceives; None if it perceives none.
        true_movers: The output port of the true `Movers` in a simulation, or of
            the `Movers` that a real robot's sensors send; None without movers.
    """

    scenario: Scenario
    world: World
    station: Diagram
    odometry: OutputPort
    velocity: OutputPort
    localization: BaseLocalization | None
    configuration: OutputPort
    targets: Targets
    oracle: DistanceOracle
    law: ReactiveLaw
    controller: ReactiveController
    selector: GuidanceSelector | None
    supervisor: SafetySupervisor | None
    motion_status: MotionStatusSystem
    known_movers: OutputPort | None
    true_movers: OutputPort | None

    @property
    def movers(self) -> OutputPort | None:
        """The output port of the known `Movers`, for displays and records.

        If the robot does not perceive movers, the port outputs the true movers.
        It is None if the scenario has no movers.
        """
        return self.known_movers or self.true_movers

    @property
    def report(self) -> OutputPort:
        """The output port of the controller's `TickReport`."""
        return self.controller.GetOutputPort("report")

    @property
    def executed(self) -> OutputPort:
        """The output port of the command u that the station receives.

        It is a port of the supervisor, or of the controller if there is no
        supervisor.
        """
        commander = self.supervisor or self.controller
        return commander.GetOutputPort("velocity_commanded")

    @property
    def status(self) -> OutputPort:
        """The output port of the station's `StationStatus`."""
        return self.station.GetOutputPort(ports.STATUS)


def AddControlLoop(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    add_targets: Callable[[OutputPort, ReactiveLaw], Targets],
    *,
    hardware: bool,
    ingredients: Sequence[Ingredient] = (),
    law: ReactiveLaw | None = None,
    others: Callable[..., Sequence[OutputPort]] = lambda *_: (),
) -> ControlLoop:
    """Adds the stages and closes the loop.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario that the stages are made from.
        world: The content of the scenario's files.
        add_targets: Function that adds the targets, given the output port of
            the measured configuration and the control law.
        hardware: Whether the station is the real robot. All other stages are
            the same as in a simulation.
        ingredients: Costs and constraints that are added to the scenario's
            control law.
        law: The control law; None means the scenario's control law.
        others: Function that adds further simulated robots. Its arguments are
            three output ports: the configuration q, the executed command, and
            the true `Movers` (or None). It returns the output ports of the
            further robots' movers.

    Raises:
        RemoSplatError: The station cannot be made, or there is no target.
    """
    robot = world.robot
    station = builder.AddSystem(MakeStation(scenario, world, hardware))
    odometry = AddConfiguration(builder, robot, station)
    localization = AddLocalization(builder, scenario, robot, odometry)
    configuration = odometry
    if localization is not None:
        configuration = localization.GetOutputPort("configuration")
    law = law or ReactiveLaw.make(
        scenario.controller, robot, scenario.control_period, ingredients
    )
    targets = add_targets(configuration, law)
    predictor = AddPrediction(
        builder, scenario, robot, station, hardware=hardware
    )
    planned = configuration
    if predictor is not None:
        planned = predictor.GetOutputPort("configuration")
    oracle = AddOracle(builder, scenario, world, planned)
    if robot.n_base:
        ConnectUncertainty(builder, station, localization, oracle)
    rest = RestRule(scenario.controller.rest, arrival_of(scenario))
    controller = AddController(builder, law, planned, targets, oracle, rest)
    selector = AddGuidance(
        builder, scenario, law, planned, targets, oracle, controller
    )
    armed = not hardware or scenario.hardware.shadow
    velocity = AddMeasuredVelocity(builder, robot, station)
    supervisor = AddSupervisor(
        builder, scenario, robot, controller, station, velocity, armed=armed
    )
    executed = (supervisor or controller).GetOutputPort("velocity_commanded")
    true_movers = AddMovers(
        builder,
        scenario,
        station,
        partial(others, configuration, executed),
        hardware=hardware,
    )
    movers = true_movers
    if not hardware:
        movers = AddMoverSensor(
            builder, scenario, world, configuration, oracle, true_movers
        )
    if movers is not None:
        for system in filter(None, (controller, selector, supervisor)):
            builder.Connect(movers, system.GetInputPort("movers"))
    motion_status = AddMotionStatus(
        builder,
        scenario,
        world,
        configuration,
        targets,
        oracle,
        controller,
        selector,
        supervisor,
        movers,
    )
    loop = ControlLoop(
        scenario=scenario,
        world=world,
        station=station,
        odometry=odometry,
        velocity=velocity,
        localization=localization,
        configuration=configuration,
        targets=targets,
        oracle=oracle,
        law=law,
        controller=controller,
        selector=selector,
        supervisor=supervisor,
        motion_status=motion_status,
        known_movers=movers,
        true_movers=true_movers,
    )
    _Close(builder, loop, predictor, hardware=hardware)
    return loop


def _Close(
    builder: DiagramBuilder,
    loop: ControlLoop,
    predictor: MotionPredictor | None,
    *,
    hardware: bool,
) -> None:
    """Connects the command to the station and to the predictor."""
    scenario, robot, executed = loop.scenario, loop.world.robot, loop.executed
    carried_out = executed
    if not hardware:
        carried_out = AddActuators(builder, scenario, robot, executed)
    ConnectCommand(
        builder,
        robot,
        carried_out,
        loop.station,
        task_port(loop.targets, "hand_command"),
    )
    ConnectTask(
        builder,
        loop.targets,
        robot,
        loop.station,
        loop.velocity,
        executed,
        loop.oracle,
        loop.controller,
    )
    if predictor is not None:
        ConnectPrediction(
            builder,
            predictor,
            filter(None, (loop.controller, loop.selector, loop.supervisor)),
            configuration=loop.configuration,
            odometry=loop.odometry,
            velocity_executed=executed,
        )
