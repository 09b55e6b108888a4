"""Adds the station (simulated or real robot) and the base's localisation."""

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.stages.movers import tracks_of
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.mapping.localization.base_localization import (
    BaseLocalization,
)
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import movers_at
from remosplat_drake.station.base_uncertainty import BaseUncertainty
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import DynamicStation


def MakeStation(scenario: Scenario, world: World, hardware: bool) -> Diagram:
    """Makes the station of a scenario, simulated or real.

    Args:
        scenario: The scenario.
        world: The content of the scenario's files.
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
        scene, objects = world.truth, ()
        if isinstance(scenario.station, DynamicStation):
            # The fixed scene excludes the objects. In the station, they are
            # separate bodies, which may move.
            scene, objects = world.fixed_truth, world.objects
        return MakeSimulatedStation(
            config=scenario.station,
            robot=world.robot,
            scene=scene,
            q0=world.q0,
            wrist_camera=camera,
            movers=list(movers_at(tracks_of(scenario), 0.0)),
            objects=objects,
        )
    except RemoSplatError as error:
        raise RemoSplatError(f"{scenario.source}: {error}") from error


def AddLocalization(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    odometry: OutputPort,
) -> BaseLocalization | None:
    """Adds the correction of a mobile base's odometry by the live map.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot.
        odometry: The output port of the measured q, n_q entries.

    Returns:
        The system; None if the base is fixed or its odometry is not corrected.
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


def ConnectUncertainty(
    builder: DiagramBuilder,
    station: Diagram,
    localization: BaseLocalization | None,
    oracle: DistanceOracle,
) -> None:
    """Connects the uncertainty of the base's pose to the oracle.

    Args:
        builder: The builder of the diagram.
        station: The robot, simulated or real, as a system.
        localization: The system that corrects the base's pose by the live map;
            None if the odometry is not corrected.
        oracle: The system that measures distances to the map.
    """
    uncertainty = BaseUncertainty.AddToBuilder(builder, station)
    name = "base_uncertainty"
    if localization is not None:
        builder.Connect(uncertainty, localization.GetInputPort(name))
        uncertainty = localization.GetOutputPort(name)
    builder.Connect(uncertainty, oracle.GetInputPort(name))
