"""`MakeHardwareStation`: the robot behind the ports of `ports.py`."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder

from remosplat_drake.errors import RemoSplatError
from remosplat_drake.robot.robot_model import RobotModel, add_robot_model
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.config import (
    DynamicStationConfig,
    KinematicStationConfig,
    WristCameraConfig,
    check_kinematic_config,
)
from remosplat_drake.station.export import export_ports
from remosplat_drake.station.hand import hand_geometry
from remosplat_drake.station.kinematic_robot import KinematicRobot


def MakeHardwareStation(
    *,
    config: KinematicStationConfig | DynamicStationConfig,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    wrist_camera: WristCameraConfig | None = None,
    hardware: bool = False,
) -> Diagram:
    """Builds a station: the robot behind one set of ports.

    Args:
        config: Which simulation, and its settings.
        robot: The robot; its description names the ports.
        scene: What the camera sees and the robot may bump into; or nothing.
        q0: Configuration to start from (x, y, yaw, arm), shape (n_q,).
        wrist_camera: None leaves the camera and its ports out.
        hardware: Whether to drive the real robot instead.

    Returns:
        A diagram with the ports of `ports.station_ports`, and ground truth
        under names that begin with `cheat.`.

    Raises:
        RemoSplatError: A setting is unusable, or `hardware` is set.
    """
    if hardware:
        raise RemoSplatError(
            "there is no hardware station yet; run without --hardware"
        )
    q0 = np.asarray(q0, float)
    if q0.shape != (robot.n_q,) or not np.isfinite(q0).all():
        raise RemoSplatError(
            f"q0: expected {robot.n_q} finite numbers (base pose, then arm),"
            f" got {q0.tolist()}"
        )
    if isinstance(config, DynamicStationConfig):
        raise RemoSplatError("there is no dynamic station yet")
    return _make_kinematic_station(config, robot, scene, q0, wrist_camera)


def _make_kinematic_station(
    config: KinematicStationConfig,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    wrist_camera: WristCameraConfig | None,
) -> Diagram:
    check_kinematic_config(config)
    plant = MultibodyPlant(time_step=0.0)
    add_robot_model(robot.description, plant)
    plant.Finalize()
    builder = DiagramBuilder()
    system = builder.AddNamedSystem(
        "kinematic_robot",
        KinematicRobot(
            robot=robot,
            hand=hand_geometry(robot.description, plant),
            hand_speed=config.hand_speed,
            q0=q0,
        ),
    )
    export_ports(builder, robot.description, [system])
    station = builder.Build()
    station.set_name("station")
    return station
