"""The kinematic station: a `KinematicRobot`, with geometry for a camera."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import AffineSystem, ConstantValueSource
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import (
    SceneObject,
    check_names,
)
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.export import export_ports
from remosplat_drake.station.hand import finger_joints, hand_geometries
from remosplat_drake.station.kinematic_robot import KinematicRobot
from remosplat_drake.station.robot_visuals import add_robot_visuals
from remosplat_drake.station.scene_geometry import add_scene_geometry
from remosplat_drake.station.station_camera import StationCamera
from remosplat_drake.station.station_config import KinematicStation


def make_kinematic_station(
    config: KinematicStation,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    wrist_camera: StationCamera | None,
    objects: Sequence[SceneObject] = (),
) -> Diagram:
    """Builds a station whose robot reaches commanded velocities at once.

    If there is no camera, the diagram has no geometry, and building it takes
    about two milliseconds.

    Args:
        config: Settings of the station.
        robot: The robot; its description names the ports.
        scene: The solids that the camera sees; None for an empty scene.
        q0: Configuration at the start, shape (n_q,).
        wrist_camera: The wrist camera; None if there is none.
        objects: Objects in the scene, which do not move.

    Returns:
        A diagram with the ports of `signals.station_ports`. If there is a
        camera, it also has the output `cheat.query_object`, and if there are
        objects, `cheat.objects`.

    Raises:
        RemoSplatError: A setting is unusable.
    """
    check_ranges(config, field="station")
    builder = DiagramBuilder()
    plant = MultibodyPlant(time_step=0.0)
    scene_graph = None
    if wrist_camera is not None:
        scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
        plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot_model(robot.description, plant)
    if scene_graph is not None:
        add_scene_geometry(plant, scene, solid=False)
        add_robot_visuals(plant, scene_graph, robot)
    plant.Finalize()
    hands = hand_geometries(robot.description, plant)
    system = builder.AddNamedSystem(
        "kinematic_robot",
        KinematicRobot(
            robot=robot,
            hands=hands,
            hand_speed=config.hand_speed,
            q0=q0,
            odometry_drift=config.odometry_drift,
        ),
    )
    if objects:
        check_names(objects)
        lying = builder.AddNamedSystem(
            "objects", ConstantValueSource(Value[object](tuple(objects)))
        )
        builder.ExportOutput(lying.get_output_port(), ports.CHEAT_OBJECTS)
    camera = None
    if scene_graph is not None and wrist_camera is not None:
        joints = (*robot.joint_names, *finger_joints(hands))
        _connect_posture(builder, plant, scene_graph, system, robot, joints)
        camera = wrist_camera.AddToStation(builder, plant, scene_graph)
        builder.ExportOutput(
            scene_graph.get_query_output_port(), ports.CHEAT_QUERY_OBJECT
        )
    export_ports(builder, robot.description, [system], camera)
    station = builder.Build()
    station.set_name("station")
    return station


def _connect_posture(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    system: KinematicRobot,
    robot: RobotModel,
    joints: Sequence[str],
) -> None:
    """Computes the poses of the geometry from the integrated configuration."""
    D = np.zeros((plant.num_positions(), len(joints)))
    for column, name in enumerate(joints):
        D[plant.GetJointByName(name).position_start(), column] = 1.0
    y0 = np.zeros(len(D))
    for name, position in robot.description.locked.items():
        if name not in joints:
            y0[plant.GetJointByName(name).position_start()] = position
    reorder = builder.AddNamedSystem(
        "plant_positions", AffineSystem(D=D, y0=y0)
    )
    poses = builder.AddNamedSystem(
        "geometry_poses", MultibodyPositionToGeometryPose(plant)
    )
    source_id = plant.get_source_id()
    assert source_id is not None
    builder.Connect(system.GetOutputPort("posture"), reorder.get_input_port())
    builder.Connect(reorder.get_output_port(), poses.get_input_port())
    builder.Connect(
        poses.get_output_port(), scene_graph.get_source_pose_port(source_id)
    )
