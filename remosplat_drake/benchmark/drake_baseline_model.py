"""Builds `drake_baseline`'s collision model: spheres in a moving scene.

The plant's world frame is the robot's base frame B. The base therefore remains
at zero, and a planar joint moves the scene. The plant is built from the robot's
kinematic tree. The robot's model file would add further collision shapes, and a
base that can move sideways.
"""

import dataclasses as dc

import numpy as np
from pydrake.common import Parallelism
from pydrake.geometry import Box as BoxShape
from pydrake.geometry import Cylinder as CylinderShape
from pydrake.geometry import Shape, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    PlanarJoint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    SpatialInertia,
    WeldJoint,
)
from pydrake.planning import RobotDiagramBuilder, SceneGraphCollisionChecker

from remosplat_drake.robot.kinematics import PRISMATIC, REVOLUTE
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

SIDEWAYS = 1
"""Index of the base's sideways position in the plant's positions. A
differential base cannot move sideways."""

_FRICTION = CoulombFriction(0.0, 0.0)
_INERTIA = SpatialInertia.SolidSphereWithMass(1.0, 0.1)


@dc.dataclass(frozen=True, eq=False)
class CollisionModel:
    """A collision checker of Drake. Its first positions are in the order of u.

    Attributes:
        checker: Drake's checker, for the distances between robot links and the
            scene.
        n_u: Number of the robot's degrees of freedom: forward, yaw, arm
            joints.
        end_effector: Scoped name of the end-effector frame E in the plant.
    """

    checker: SceneGraphCollisionChecker
    n_u: int
    end_effector: str

    def positions(self, q: np.ndarray) -> np.ndarray:
        """Returns the plant's positions at q = (x, y, yaw, arm)."""
        x, y, yaw = q[:3]
        c, s = np.cos(yaw), np.sin(yaw)
        X_BW = [-c * x - s * y, s * x - c * y, -yaw]
        return np.array([0.0, 0.0, *q[3:], *X_BW])


def make_collision_model(
    robot: RobotModel, scene: PrimitiveScene
) -> CollisionModel:
    """Builds the checker from the robot's spheres and the scene's solids.

    Robot links are not checked against each other. Links on the floor are not
    checked against solids that are below the floor height, where their spheres
    ignore the scene.

    Args:
        robot: Model of a robot with a differential base.
        scene: The solids that the robot is checked against.
    """
    builder = RobotDiagramBuilder(time_step=0.0)
    plant = builder.plant()
    links = _add_robot(plant, robot)
    low = _add_scene(plant, scene, _floor_height(robot))
    plant.Finalize()
    checker = SceneGraphCollisionChecker(
        model=builder.Build(),
        robot_model_instances=[links[0].model_instance()],
        edge_step_size=0.1,  # Unused here, but required.
        implicit_context_parallelism=Parallelism(1),
    )
    for i, link in enumerate(links):
        for other in links[:i]:
            checker.SetCollisionFilteredBetween(
                link.index(), other.index(), True
            )
        if link.name() in robot.description.floor_links:
            checker.SetCollisionFilteredBetween(link.index(), low.index(), True)
    end_effector = checker.plant().GetFrameByName("end_effector")
    return CollisionModel(
        checker, robot.n_u, end_effector.scoped_name().get_full()
    )


def _add_robot(plant: MultibodyPlant, robot: RobotModel) -> list[RigidBody]:
    """Adds the robot: links, joints, spheres and the end-effector frame E."""
    tree = robot.tree
    instance = plant.AddModelInstance("robot")
    links = [plant.world_body()]
    for i, name in enumerate(tree.names[1:], start=1):
        link = plant.AddRigidBody(name, instance, _INERTIA)
        links.append(link)
        _add_joint(plant, robot, i, links[tree.parent[i]], link)
    for i, name in enumerate(robot.spheres.links):
        plant.RegisterCollisionGeometry(
            links[tree.index(name)],
            RigidTransform(robot.spheres.p_LS[i]),
            Sphere(float(robot.spheres.radius[i])),
            f"sphere_{i}",
            _FRICTION,
        )
    last = int(np.flatnonzero(tree.position == robot.n_q - 1)[0])
    q = np.array([0.0, 0.0, 0.0, *robot.home])
    X_LE = np.linalg.inv(robot.body_poses(q)[last]) @ robot.end_effector_pose(q)
    _offset_frame(plant, "end_effector", links[last], X_LE)
    return links[1:]


def _add_joint(
    plant: MultibodyPlant,
    robot: RobotModel,
    i: int,
    parent: RigidBody,
    link: RigidBody,
) -> None:
    """Joins link i to its parent; immovable joints become welds."""
    tree, name = robot.tree, f"joint_{i}"
    F = _offset_frame(plant, f"{name}_F", parent, tree.X_PF[i])
    M = _offset_frame(plant, f"{name}_M", link, np.linalg.inv(tree.X_MB[i]))
    axis, moves = tree.axis_F[i], tree.position[i] not in (-1, SIDEWAYS)
    if moves and tree.kind[i] == REVOLUTE:
        plant.AddJoint(RevoluteJoint(name, F, M, axis))
    elif moves and tree.kind[i] == PRISMATIC:
        plant.AddJoint(PrismaticJoint(name, F, M, axis))
    else:
        assert tree.kind[i] != REVOLUTE
        X_FM = RigidTransform(axis * tree.offset[i])
        plant.AddJoint(WeldJoint(name, F, M, X_FM))


def _offset_frame(
    plant: MultibodyPlant, name: str, body: RigidBody, X_BF: np.ndarray
) -> Frame:
    return plant.AddFrame(
        FixedOffsetFrame(name, body.body_frame(), RigidTransform(X_BF))
    )


def _add_scene(
    plant: MultibodyPlant, scene: PrimitiveScene, floor_height: float
) -> RigidBody:
    """Adds the scene as two bodies; returns the body of low solids."""
    instance = plant.AddModelInstance("scene")
    solids = plant.AddRigidBody("solids", instance, _INERTIA)
    low = plant.AddRigidBody("low", instance, _INERTIA)
    B, W = plant.world_frame(), solids.body_frame()
    plant.AddJoint(PlanarJoint("base_to_scene", B, W))
    plant.WeldFrames(W, low.body_frame())
    for i, primitive in enumerate(scene.primitives):
        plant.RegisterCollisionGeometry(
            low if primitive.top < floor_height else solids,
            primitive.X_WP,
            _shape(primitive),
            f"solid_{i}",
            _FRICTION,
        )
    return low


def _shape(primitive: Box | Cylinder) -> Shape:
    if isinstance(primitive, Box):
        return BoxShape(*(2 * primitive.half_extents))
    return CylinderShape(primitive.radius, 2 * primitive.half_height)


def _floor_height(robot: RobotModel) -> float:
    """Returns the height below which floor links ignore the scene [m]."""
    q = np.array([0.0, 0.0, 0.0, *robot.home])
    return float(robot.spheres_at(q).ignore_below.max())
