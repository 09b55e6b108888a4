"""`MakeHardwareStation`: the robot behind the ports of `ports.py`."""

import numpy as np
from pydrake.systems.framework import Diagram

from remosplat_drake.errors import RemoSplatError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.config import (
    DynamicStation,
    KinematicStation,
    WristCameraConfig,
)
from remosplat_drake.station.dynamic_station import make_dynamic_station
from remosplat_drake.station.hardware.config import HardwareConfig
from remosplat_drake.station.hardware.hardware_station import HardwareStation
from remosplat_drake.station.kinematic_station import make_kinematic_station


def MakeHardwareStation(
    *,
    config: KinematicStation | DynamicStation,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    wrist_camera: WristCameraConfig | None = None,
    hardware: HardwareConfig | None = None,
) -> Diagram:
    """Builds a station: the robot behind one set of ports.

    Args:
        config: Which simulation, and its settings.
        robot: The robot; its description names the ports.
        scene: What the camera sees and the robot may bump into; or nothing.
        q0: Configuration to start from (x, y, yaw, arm), shape (n_q,).
        wrist_camera: None leaves the camera and its ports out.
        hardware: Where the real robot's drivers are; None simulates. On the
            real robot `config`, `scene` and `q0` have no say.

    Returns:
        A diagram with the ports of `ports.station_ports`. Simulated ones
        have ground truth, too, under names that begin with `cheat.`.

    Raises:
        RemoSplatError: A setting is unusable.
    """
    if hardware is not None:
        return HardwareStation(
            config=hardware, robot=robot, wrist_camera=wrist_camera
        )
    q0 = np.asarray(q0, float)
    if q0.shape != (robot.n_q,) or not np.isfinite(q0).all():
        raise RemoSplatError(
            f"q0: expected {robot.n_q} finite numbers (base pose, then arm),"
            f" got {q0.tolist()}"
        )
    if isinstance(config, DynamicStation):
        return make_dynamic_station(config, robot, scene, q0, wrist_camera)
    return make_kinematic_station(config, robot, scene, q0, wrist_camera)
