"""`ControlLoop`: the stages that drive the robot, wired into a circle.

station --configuration--> oracle --clearances--> controller --> supervisor
--> station

Everything else of the application looks on or adds to it.
"""

import dataclasses as dc
from collections.abc import Callable, Sequence

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.stages import (
    AddController,
    AddGuidance,
    AddOracle,
    AddSupervisor,
    MakeStation,
)
from remosplat_drake.app.world import World
from remosplat_drake.controller.guidance.guidance_selector import (
    GuidanceSelector,
)
from remosplat_drake.controller.reactive_controller import ReactiveController
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.reactive_program import Ingredient
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.safety.supervisor_system import SafetySupervisor
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.connections import AddConfiguration, ConnectCommand
from remosplat_drake.task.targets import Targets


@dc.dataclass(frozen=True, eq=False)
class ControlLoop:
    """The stages of a closed loop.

    Attributes:
        scenario: The experiment.
        world: What its files hold.
        station: The robot.
        configuration: The measured q.
        targets: Where the end effector shall go.
        oracle: Distances to the map.
        controller: The reactive controller.
        selector: The look-ahead beside it, if the scenario wants it.
        supervisor: Between controller and station, likewise.
    """

    scenario: Scenario
    world: World
    station: Diagram
    configuration: OutputPort
    targets: Targets
    oracle: DistanceOracle
    controller: ReactiveController
    selector: GuidanceSelector | None
    supervisor: SafetySupervisor | None

    @property
    def report(self) -> OutputPort:
        """The controller's tick reports."""
        return self.controller.GetOutputPort("report")

    @property
    def executed(self) -> OutputPort:
        """The command u that the station gets."""
        commander = self.supervisor or self.controller
        return commander.GetOutputPort("velocity_commanded")

    @property
    def status(self) -> OutputPort:
        """The station's."""
        return self.station.GetOutputPort(ports.STATUS)


def AddControlLoop(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    add_targets: Callable[[OutputPort], Targets],
    *,
    hardware: bool,
    ingredients: Sequence[Ingredient] = (),
) -> ControlLoop:
    """Adds the stages and closes the loop.

    Args:
        builder: Of the diagram.
        scenario: The experiment.
        world: What its files hold.
        add_targets: Adds the targets, given the measured configuration.
        hardware: Whether the station is the real robot; nothing else differs.
        ingredients: Of the control law, besides the scenario's.

    Raises:
        RemoSplatError: The station cannot be made, or there is no target.
    """
    robot = world.robot
    station = builder.AddSystem(MakeStation(scenario, world, hardware))
    configuration = AddConfiguration(builder, robot, station)
    targets = add_targets(configuration)
    oracle = AddOracle(builder, scenario, world, configuration)
    law = ReactiveLaw.make(
        scenario.controller, robot, scenario.control_period, ingredients
    )
    controller = AddController(builder, law, configuration, targets, oracle)
    selector = AddGuidance(
        builder, scenario, law, configuration, targets, oracle, controller
    )
    supervisor = AddSupervisor(builder, scenario, robot, controller, station)
    loop = ControlLoop(
        scenario,
        world,
        station,
        configuration,
        targets,
        oracle,
        controller,
        selector,
        supervisor,
    )
    ConnectCommand(builder, robot, loop.executed, station)
    return loop
