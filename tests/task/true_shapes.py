"""Judges a task by true shapes: of the robot, its load and the scene."""

import dataclasses as dc

import numpy as np
from pydrake.geometry import Box as DrakeBox
from pydrake.geometry import Cylinder as DrakeCylinder
from pydrake.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder, EventStatus

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene
from remosplat_drake.task.task import RUNNING, TaskState


@dc.dataclass(frozen=True, eq=False)
class Moment:
    """What a tick has found.

    Attributes:
        q: The configuration, shape (n_q,).
        state: How far the task was.
    """

    q: np.ndarray
    state: TaskState


def watched(application: Application) -> list[Moment]:
    """Runs a task to its end or its time limit; what each tick has found."""
    moments, targets = [], application.targets

    def watch(context):
        q = targets.GetInputPort("configuration").Eval(context)
        moments.append(Moment(np.array(q), targets.state(context)))

    simulate(application, watch)
    return moments


def simulate(application: Application, watch=lambda context: None) -> Simulator:
    """Runs a task to its end or its time limit.

    `watch` gets the context of its system at every tick.
    """
    targets = application.targets
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(simulator_config(application.scenario), simulator)

    def monitor(root):
        context = targets.GetMyContextFromRoot(root)
        watch(context)
        if targets.state(context).outcome != RUNNING:
            return EventStatus.ReachedTermination(application.diagram, "")
        return EventStatus.DidNothing()

    simulator.set_monitor(monitor)
    simulator.AdvanceTo(application.scenario.time_limit)
    return simulator


def solids_at(moment: Moment, robot) -> dict[str, object]:
    """Every object's solid where it is: in the hand, or where it stands."""
    found = {}
    for thing in moment.state.objects:
        solid = thing.solid
        payload = moment.state.payload
        if payload is not None and payload.name == thing.name:
            link = robot.tree.index(payload.link)
            X_WO = robot.body_poses(moment.q)[link] @ payload.X_LO
            solid = thing.at(RigidTransform(X_WO)).solid
        found[thing.name] = solid
    return found


def robot_clearances(moment: Moment, robot) -> dict[tuple[str, str], float]:
    """By link and object, a lower bound of the distance [m].

    Spheres enclose the links, and distances from these are exact.
    """
    spheres, links = robot.spheres_at(moment.q), np.array(robot.spheres.links)
    found = {}
    for name, solid in solids_at(moment, robot).items():
        scene = PrimitiveScene()
        kind = "cylinders" if isinstance(solid, Cylinder) else "boxes"
        field = SignedDistanceField(dc.replace(scene, **{kind: (solid,)}))
        distance = field.clearances(spheres).per_sphere(len(spheres))
        for link in dict.fromkeys(links):
            found[str(link), name] = float(distance[links == link].min())
    return found


def near_bodies(
    moments: list[Moment], robot, within: float
) -> dict[tuple[str, str], float]:
    """By names of two links, or a link and "load", their least distance [m].

    Drake computes it, by the collision shapes of the robot with open fingers.
    What holds the load is not looked at, nor what is farther away.
    """
    least: dict[tuple[str, str], float] = {}
    state = moments[0].state
    builder = DiagramBuilder()
    plant, graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    add_robot_model(robot.description, plant)
    mass = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    load = plant.AddRigidBody("load", plant.AddModelInstance("load"), mass)
    shape = _shape(state.named(state.held).solid)
    plant.RegisterCollisionGeometry(
        load, RigidTransform(), shape, "load", CoulombFriction()
    )
    plant.Finalize()
    root = builder.Build().CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    inspector, graph_context = (
        graph.model_inspector(),
        graph.GetMyContextFromRoot(root),
    )
    for moment in moments:
        q = plant.GetPositions(context)
        joints = zip(robot.joint_names, moment.q, strict=True)
        for name, position in (robot.description.locked | dict(joints)).items():
            q[plant.GetJointByName(name).position_start()] = position
        plant.SetPositions(context, q)
        X_WO = solids_at(moment, robot)[state.held].X_WP
        plant.SetFreeBodyPose(context, load, X_WO)
        query = graph.get_query_output_port().Eval(graph_context)
        holders = moment.state.payload.holders
        holding = {tuple(sorted(("load", link))) for link in holders}
        for found in query.ComputeSignedDistancePairwiseClosestPoints(within):
            ids = map(inspector.GetFrameId, (found.id_A, found.id_B))
            bodies = (plant.GetBodyFromFrameId(each) for each in ids)
            pair = tuple(sorted(body.name() for body in bodies))
            if pair not in holding:
                least[pair] = min(least.get(pair, np.inf), found.distance)
    return least


def load_clearances(moments: list[Moment], robot) -> dict[str, float]:
    """By object, the least distance of what is carried from it [m].

    Drake computes it, by shapes that know nothing of spheres.
    """
    least: dict[str, float] = {}
    graph, ids, state = SceneGraph(), {}, moments[0].state
    source, frame = graph.RegisterSource("objects"), GeometryFrame("load")
    graph.RegisterFrame(source, frame)
    for thing in state.objects:
        shape, pose = _shape(thing.solid), RigidTransform()
        if thing.name != state.held:
            pose = thing.X_WO
        instance = GeometryInstance(pose, shape, thing.name)
        instance.set_proximity_properties(ProximityProperties())
        ids[thing.name] = (
            graph.RegisterGeometry(source, frame.id(), instance)
            if thing.name == state.held
            else graph.RegisterAnchoredGeometry(source, instance)
        )
    context = graph.CreateDefaultContext()
    load = ids.pop(state.held)
    for moment in moments:
        poses = FramePoseVector()
        X_WO = solids_at(moment, robot)[state.held].X_WP
        poses.set_value(frame.id(), X_WO)
        graph.get_source_pose_port(source).FixValue(context, poses)
        query = graph.get_query_output_port().Eval(context)
        for name, other in ids.items():
            found = query.ComputeSignedDistancePairClosestPoints(load, other)
            least[name] = min(least.get(name, np.inf), found.distance)
    return least


def _shape(solid):
    if isinstance(solid, Cylinder):
        return DrakeCylinder(solid.radius, 2.0 * solid.half_height)
    return DrakeBox(*(2.0 * solid.half_extents))
