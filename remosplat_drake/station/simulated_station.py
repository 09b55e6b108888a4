"""`MakeSimulatedStation`: builds the station of a simulated robot."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import Diagram

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.dynamic_station import make_dynamic_station
from remosplat_drake.station.kinematic_station import make_kinematic_station
from remosplat_drake.station.station_camera import StationCamera
from remosplat_drake.station.station_check import check_station
from remosplat_drake.station.station_config import (
    DynamicStation,
    KinematicStation,
    StationMaker,
)


def MakeSimulatedStation(
    *,
    config: KinematicStation | DynamicStation | StationMaker,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    wrist_camera: StationCamera | None = None,
    movers: Sequence[Mover] = (),
    objects: Sequence[SceneObject] = (),
) -> Diagram:
    """Builds the diagram of a simulated robot, with the ports of a station.

    Args:
        config: The kind of simulation, and its settings.
        robot: The robot; its description names the ports.
        scene: The solids that the camera sees and with which the robot may
            collide; None for an empty scene.
        q0: Configuration (x, y, yaw, arm) at the start, shape (n_q,) [m, rad].
        wrist_camera: The wrist camera, for example a `WristCameraConfig`; None
            for no camera and no camera ports.
        movers: The movers (moving objects) at the start. A dynamic station has
            a body for each mover, and an input port `movers` for their later
            states.
        objects: Objects that a gripper may grasp, at their initial poses. A
            station with objects has the output port `cheat.objects`.

    Returns:
        A diagram with the ports of `signals.station_ports`, and with ground
        truth under names that begin with `cheat.`.

    Raises:
        RemoSplatError: A setting is unusable, or q0 has another shape or is
            not finite.
    """
    q0 = np.asarray(q0, float)
    if q0.shape != (robot.n_q,) or not np.isfinite(q0).all():
        raise RemoSplatError(
            f"q0: expected {robot.n_q} finite numbers (base pose, then arm),"
            f" got {q0.tolist()}"
        )
    if isinstance(config, KinematicStation):
        return make_kinematic_station(
            config, robot, scene, q0, wrist_camera, objects
        )
    if isinstance(config, DynamicStation):
        return make_dynamic_station(
            config, robot, scene, q0, wrist_camera, movers, objects
        )
    station = config.make(robot, scene, q0, wrist_camera)
    check_station(
        station,
        robot.description,
        wrist_camera is not None,
        type(config).__name__,
    )
    return station
