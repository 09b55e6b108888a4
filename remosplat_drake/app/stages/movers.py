"""Adds the movers (moving obstacles) and the robot's perception of them."""

from collections.abc import Callable, Sequence

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.other_robot_config import OtherRobot
from remosplat_drake.app.scenario import TRUTH, Scenario
from remosplat_drake.app.world import World
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.scene.moving.track import Track
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.merged_movers import MergedMovers
from remosplat_drake.station.mover_sensing import KnownMovers
from remosplat_drake.station.mover_sensor_system import MoverSensorSystem
from remosplat_drake.station.mover_source import MoverSource


def AddMovers(
    builder: DiagramBuilder,
    scenario: Scenario,
    station: Diagram,
    others: Callable[[OutputPort | None], Sequence[OutputPort]],
    *,
    hardware: bool,
) -> OutputPort | None:
    """Adds all movers of a simulation, or the movers that sensors send.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        station: The robot, simulated or real, as a system.
        others: Function that adds further simulated robots. Its argument is the
            output port of all movers except these robots (or None). It returns
            the output ports of the robots' movers.
        hardware: Whether the station is the real robot.

    Returns:
        The output port of the `Movers`; None if no movers are known.
    """
    movers = _things(builder, scenario, station, hardware=hardware)
    around = others(movers)
    return MergedMovers.AddToBuilder(
        builder, [*filter(None, [movers]), *around]
    )


def _things(
    builder: DiagramBuilder,
    scenario: Scenario,
    station: Diagram,
    *,
    hardware: bool,
) -> OutputPort | None:
    """Returns the port of all movers except other robots; None without any."""
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
    """Returns the motions (tracks) of a scenario's movers, except robots.

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
    """Adds the simulated perception of movers.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        oracle: The system that outputs the map, which cameras use.
        truth: The output port of the true `Movers`; None if there are none.

    Returns:
        The output port of the known `Movers`; None if the robot perceives none.
    """
    if truth is None:
        return None
    if scenario.movers_from != TRUTH:
        # Runs without cameras do not import the modules of cameras.
        from remosplat_drake.app.stages.camera_detection import (
            AddCameraDetection,
        )

        return AddCameraDetection(
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
