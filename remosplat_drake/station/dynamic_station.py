"""Builds the dynamic station, with rigid bodies, motors and contact."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Diagram, DiagramBuilder

from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.contact_materials import soften_pads
from remosplat_drake.station.contact_monitor import ContactMonitor
from remosplat_drake.station.export import export_ports
from remosplat_drake.station.hand import HandGeometry, hand_geometries
from remosplat_drake.station.motors import Motors, make_motors, set_motor_gains
from remosplat_drake.station.mover_bodies import (
    MoverDriver,
    add_mover_bodies,
    let_pass,
)
from remosplat_drake.station.neighbours import let_neighbours_overlap
from remosplat_drake.station.object_bodies import (
    ObjectReader,
    add_object_bodies,
)
from remosplat_drake.station.robot_visuals import add_robot_visuals
from remosplat_drake.station.scene_geometry import add_scene_geometry
from remosplat_drake.station.state_reader import StateReader
from remosplat_drake.station.station_camera import StationCamera
from remosplat_drake.station.station_config import DynamicStation
from remosplat_drake.station.velocity_driver import VelocityDriver


def make_dynamic_station(
    config: DynamicStation,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    wrist_camera: StationCamera | None,
    movers: Sequence[Mover] = (),
    objects: Sequence[SceneObject] = (),
) -> Diagram:
    """Builds a station with dynamics and contact.

    Gravity does not act on the robot: the Panda compensates its own weight, and
    planar joints keep the base on the floor.

    Args:
        config: Physics of the station.
        robot: The robot; its description names the ports.
        scene: The solids in the scene; None for an empty scene.
        q0: Configuration at the start, shape (n_q,).
        wrist_camera: The wrist camera; None if there is none.
        movers: The movers (moving objects) at the start. They can touch the
            robot.
        objects: Objects that a gripper may grasp, at their initial poses. Only
            gravity and contact forces move them.

    Returns:
        A diagram with the ports of `signals.station_ports`. It has further
        outputs with ground truth: `cheat.contact`, `cheat.query_object` and, if
        there are objects, `cheat.objects`. If there are movers, it has the
        input port `movers`, whose `Movers` must have the same number and order.

    Raises:
        RemoSplatError: A setting is unusable.
    """
    builder = DiagramBuilder()
    body = add_dynamic_body(builder, config, robot, scene, q0, movers, objects)
    plant, scene_graph = body.plant, body.scene_graph
    driver = VelocityDriver(
        plant=plant,
        robot=robot,
        hands=body.hands,
        motors=body.motors,
        hand_speed=config.hand_speed,
    ).AddToBuilder(builder, plant)
    reader = StateReader(
        plant=plant, robot=robot, hands=body.hands
    ).AddToBuilder(builder, plant)
    if body.movers:
        MoverDriver.AddToBuilder(builder, plant, body.movers)
    if objects:
        ObjectReader.AddToBuilder(builder, plant, objects, body.objects)
    camera = None
    if wrist_camera is not None:
        camera = wrist_camera.AddToStation(builder, plant, scene_graph)
    _export_ground_truth(builder, plant, scene_graph)
    export_ports(builder, robot.description, [driver, reader], camera)
    station = builder.Build()
    station.set_name("station")
    return station


@dc.dataclass(frozen=True, eq=False)
class DynamicBody:
    """The plant of a dynamic station, and its moving parts.

    Attributes:
        plant: The finalized plant.
        scene_graph: Scene graph with the plant's geometry.
        hands: Geometry of the grippers.
        motors: The motors. Their gains are set in the plant's actuators.
        movers: The bodies of the movers.
        objects: The bodies of the objects.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    hands: tuple[HandGeometry, ...]
    motors: Motors
    movers: Sequence[RigidBody] = ()
    objects: Sequence[RigidBody] = ()


def add_dynamic_body(
    builder: DiagramBuilder,
    config: DynamicStation,
    robot: RobotModel,
    scene: PrimitiveScene | None,
    q0: np.ndarray,
    movers: Sequence[Mover] = (),
    objects: Sequence[SceneObject] = (),
) -> DynamicBody:
    """Adds the plant of a dynamic station, without drivers or sensors.

    Args:
        builder: Builder of the diagram.
        config: Physics of the station.
        robot: The robot.
        scene: The solids in the scene; None for an empty scene.
        q0: Configuration at the start, shape (n_q,).
        movers: The movers at the start.
        objects: Objects that a gripper may grasp, at their initial poses.

    Raises:
        RemoSplatError: A setting is unusable.
    """
    check_ranges(config, field="station")
    plant, scene_graph = AddMultibodyPlant(
        MultibodyPlantConfig(
            time_step=config.time_step,
            contact_model="hydroelastic_with_fallback",
            discrete_contact_approximation=(
                config.discrete_contact_approximation
            ),
        ),
        builder,
    )
    for instance in add_robot_model(robot.description, plant):
        plant.set_gravity_enabled(instance, False)
    add_scene_geometry(plant, scene, solid=config.collide_with_scene)
    add_robot_visuals(plant, scene_graph, robot)
    hands = hand_geometries(robot.description, plant)
    motors = make_motors(robot, hands, q0, config)
    set_motor_gains(plant, motors)
    for hand in hands:
        _couple_fingers(plant, hand)
    _set_start(plant, robot, q0)
    bodies = add_mover_bodies(plant, movers)
    things = add_object_bodies(plant, objects, config.object_friction)
    plant.Finalize()
    let_neighbours_overlap(plant, scene_graph, robot)
    for hand in hands:
        soften_pads(plant, scene_graph, hand, config.pad_modulus)
    let_pass(plant, scene_graph, bodies)
    return DynamicBody(plant, scene_graph, hands, motors, bodies, things)


def _couple_fingers(plant: MultibodyPlant, hand: HandGeometry) -> None:
    """Couples the fingers of a hand, so that they open by the same amount."""
    for name in hand.joints[1:]:
        plant.AddCouplerConstraint(
            plant.GetJointByName(hand.joints[0]),
            plant.GetJointByName(name),
            gear_ratio=1.0,
        )


def _set_start(
    plant: MultibodyPlant, robot: RobotModel, q0: np.ndarray
) -> None:
    start = dict(zip(robot.joint_names, q0, strict=True))
    for name, position in {**robot.description.locked, **start}.items():
        plant.GetJointByName(name).set_default_positions([position])


def _export_ground_truth(
    builder: DiagramBuilder, plant: MultibodyPlant, scene_graph: SceneGraph
) -> None:
    monitor = builder.AddNamedSystem(
        "contact_monitor",
        ContactMonitor(plant=plant, inspector=scene_graph.model_inspector()),
    )
    builder.Connect(
        plant.get_contact_results_output_port(), monitor.get_input_port()
    )
    builder.ExportOutput(
        monitor.GetOutputPort(ports.CHEAT_CONTACT), ports.CHEAT_CONTACT
    )
    builder.ExportOutput(
        scene_graph.get_query_output_port(), ports.CHEAT_QUERY_OBJECT
    )
