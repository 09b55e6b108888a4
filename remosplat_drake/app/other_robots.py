"""The other robots of a simulation: control loops beside the application's.

Each of these robots is a separate diagram. Its input is the movers (moving
obstacles) around it. Its output is the movers that represent it to other
robots.
"""

import copy
from functools import partial

from pydrake.common.value import Value
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import PassThrough

from remosplat_drake.app.control_loop import AddControlLoop
from remosplat_drake.app.other_robot_config import OURS, THEIRS, OtherRobot
from remosplat_drake.app.scenario import Scenario, load_scenario, split_spec
from remosplat_drake.app.stages.targets import AddTargets
from remosplat_drake.app.world import World, load_world
from remosplat_drake.scene.mover import Movers
from remosplat_drake.station.merged_movers import MergedMovers
from remosplat_drake.station.robot_movers import RobotMovers


class DrivenRobot(Diagram):
    """A robot with its control loop, as a part of another simulation.

    The input port `movers` takes the moving obstacles around the robot. The
    output port `movers` outputs the robot's links as moving obstacles, for
    other robots.

    Attributes:
        loop: The stages of its control loop.
    """

    def __init__(self, config: OtherRobot, scenario: Scenario):
        """Builds the control loop of the other robot.

        Args:
            config: The name and the bounds of the robot.
            scenario: The scenario that drives it.

        Raises:
            RemoSplatError: A file is unusable, or there is no target.
        """
        super().__init__()
        world = load_world(scenario)
        builder = DiagramBuilder()
        around = builder.AddNamedSystem(
            "around", PassThrough(Value[object](Movers(0.0)))
        )
        self.loop = AddControlLoop(
            builder,
            scenario,
            world,
            partial(AddTargets, builder, scenario, world),
            hardware=False,
            others=lambda *_: [around.get_output_port()],
        )
        movers = AddOwnMovers(
            builder,
            config,
            world,
            self.loop.configuration,
            self.loop.executed,
            config.name,
        )
        builder.ExportInput(around.get_input_port(), "movers")
        builder.ExportOutput(movers, "movers")
        builder.BuildInto(self)
        self.set_name(config.name)


def AddOwnMovers(
    builder: DiagramBuilder,
    config: OtherRobot,
    world: World,
    configuration: OutputPort,
    executed: OutputPort,
    name: str,
) -> OutputPort:
    """Adds a system that outputs a robot's links as movers for another robot.

    Args:
        builder: The builder of the diagram.
        config: Display name of the robot, and the bounds that the other robot
            assumes for its speed and acceleration.
        world: The content of the robot's scenario.
        configuration: The output port of its q.
        executed: The output port of the command that it executes.
        name: Display name of the robot.
    """
    return RobotMovers.AddToBuilder(
        builder,
        configuration=configuration,
        velocity=executed,
        robot=world.robot,
        name=name,
        max_speed=config.max_speed,
        max_acceleration=config.max_acceleration,
    )


def other_robots(scenario: Scenario) -> list[OtherRobot]:
    """Returns the other robots of a scenario.

    Args:
        scenario: The scenario.
    """
    return [m for m in scenario.movers if isinstance(m, OtherRobot)]


def AddOtherRobots(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    executed: OutputPort,
    movers: OutputPort | None,
) -> list[OutputPort]:
    """Adds a scenario's other robots, which avoid our robot and all movers.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of its files.
        configuration: The output port of our robot's q.
        executed: The output port of the command that our robot executes.
        movers: The output port of the true `Movers` that are not robots; None
            for none.

    Returns:
        The output ports of their movers.

    Raises:
        RemoSplatError: A robot's scenario cannot be used.
    """
    robots = {
        config.name: builder.AddSystem(
            DrivenRobot(config, scenario_of(config, scenario))
        )
        for config in other_robots(scenario)
    }
    for config in other_robots(scenario):
        ours = AddOwnMovers(
            builder, config, world, configuration, executed, "the first robot"
        )
        around = [
            other.GetOutputPort("movers")
            for name, other in robots.items()
            if name != config.name
        ]
        merged = MergedMovers.AddToBuilder(
            builder, [*filter(None, [ours, movers]), *around]
        )
        assert merged is not None
        builder.Connect(merged, robots[config.name].GetInputPort("movers"))
    return [robot.GetOutputPort("movers") for robot in robots.values()]


def scenario_of(config: OtherRobot, scenario: Scenario) -> Scenario:
    """Reads the scenario that drives another robot.

    The returned scenario has the control period of `scenario`. In it, the other
    robot yields if our robot has right of way.

    Args:
        config: The robot.
        scenario: Our scenario.

    Raises:
        RemoSplatError: There is no such scenario, or it cannot be used.
    """
    spec = config.scenario
    if split_spec(spec) is not None:
        # The file's name is relative to our scenario's folder.
        spec = str(scenario.folder / spec)
    other = load_scenario(spec)
    other.movers = []
    other.control_period = scenario.control_period
    return _keep_off(other, config) if config.right_of_way == OURS else other


def with_right_of_way(scenario: Scenario) -> Scenario:
    """Returns a scenario in which our robot avoids robots with right of way.

    Args:
        scenario: Our scenario.
    """
    for config in other_robots(scenario):
        if config.right_of_way == THEIRS:
            scenario = _keep_off(scenario, config)
    return scenario


def _keep_off(scenario: Scenario, config: OtherRobot) -> Scenario:
    yielding = copy.deepcopy(scenario)
    movers = yielding.controller.movers
    movers.separation = max(movers.separation, config.yielding)
    movers.influence = max(movers.influence, movers.separation + 0.5)
    return yielding
