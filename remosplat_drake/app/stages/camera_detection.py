"""Adds the stage of simulated cameras that detect movers."""

from pydrake.systems.framework import DiagramBuilder, OutputPort

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.world import World
from remosplat_drake.detection.known_scene import KnownScene, surface_points
from remosplat_drake.detection.simulated.camera_detection import (
    CameraDetection,
    simulated_detection,
)
from remosplat_drake.oracle.distance_oracle import DistanceOracle


def AddCameraDetection(
    builder: DiagramBuilder,
    scenario: Scenario,
    world: World,
    configuration: OutputPort,
    oracle: DistanceOracle,
    truth: OutputPort,
) -> OutputPort:
    """Adds the simulated cameras that detect movers.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        world: The content of the scenario's files.
        configuration: The output port of the measured q, n_q entries.
        oracle: The system that outputs the map.
        truth: The output port of the true `Movers`.

    Returns:
        The output port of the detected `Movers`.
    """
    detection = CameraDetection.AddToBuilder(
        builder,
        detection=simulated_detection(
            scenario.cameras,
            world.robot,
            world.truth,
            known_scene(scenario, world),
            scenario.detection,
            scenario.seed,
        ),
        configuration=configuration,
        truth=truth,
        distance_field=oracle.GetOutputPort("distance_field"),
        period=scenario.control_period,
    )
    return detection.GetOutputPort("movers")


def known_scene(scenario: Scenario, world: World) -> KnownScene:
    """Makes the scene that the detection of movers compares images with.

    Args:
        scenario: The scenario.
        world: The content of its files.
    """
    surface_W = surface_points(world.splat_W, None)
    if not len(surface_W):
        surface_W = surface_points(None, world.truth)
    return KnownScene(world.field, scenario.detection, surface_W)
