"""`mujoco_model`: a robot and solids as a model of MuJoCo.

Kinematics, masses, limits and collision shapes are those of the robot's model
file. Dynamics, contact and their integration are MuJoCo's.
"""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.robot.kinematics import FIXED, REVOLUTE
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.link_pairs import possible_pairs
from remosplat_drake.robot.self_collision.shapes import read_collision_shapes
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.station.motors import Motors, actuator_by_joint

STEP = 0.001
"""Time between two steps of MuJoCo [s]."""

_JOINTS = {
    True: mujoco.mjtJoint.mjJNT_HINGE,
    False: mujoco.mjtJoint.mjJNT_SLIDE,
}


def mujoco_model(
    robot: RobotModel,
    plant: MultibodyPlant,
    scene: PrimitiveScene | None,
    motors: Motors,
) -> mujoco.MjModel:
    """Makes the model; gravity does not act on it.

    Args:
        robot: The robot.
        plant: Its finalized plant, which has its masses and limits.
        scene: The solids that the robot may bump into; None for none.
        motors: The motors of its joints, of base, arm and fingers.

    Returns:
        A model in which each joint has the name of the robot's, and each motor
        that of its joint; no effort bounds the motors.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = STEP
    spec.option.gravity = np.zeros(3)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # Frames between the slides of a base have no mass.
    spec.compiler.boundmass, spec.compiler.boundinertia = 1e-6, 1e-9
    _add_scene(spec, scene)
    _add_links(spec, robot, plant, motors.joints)
    _add_shapes(spec, robot)
    _add_motors(spec, motors)
    return spec.compile()


def _add_links(
    spec: mujoco.MjSpec,
    robot: RobotModel,
    plant: MultibodyPlant,
    moving: Sequence[str],
) -> None:
    """Adds the robot's links; joints that have no motor are fixed."""
    tree, bodies = robot.tree, [spec.worldbody]
    joints = _inboard_joints(plant)
    for i, name in enumerate(tree.names[1:], start=1):
        joint = joints.get(name, "")
        kind, X_FM = tree.kind[i], np.eye(4)
        if kind != FIXED and joint not in moving:
            X_FM = _moved(kind, tree.axis_F[i], tree.offset[i])
        X_PB = RigidTransform(tree.X_PF[i] @ X_FM @ tree.X_MB[i])
        body = bodies[tree.parent[i]].add_body(name=name, **_pose(X_PB))
        bodies.append(body)
        _add_mass(body, plant.GetBodyByName(name))
        if joint in moving:
            X_BM = np.linalg.inv(tree.X_MB[i])
            drakes = plant.GetJointByName(joint)
            lower = drakes.position_lower_limits()[0]
            upper = drakes.position_upper_limits()[0]
            body.add_joint(
                name=joint,
                type=_JOINTS[bool(kind == REVOLUTE)],
                pos=X_BM[:3, 3],
                axis=X_BM[:3, :3] @ tree.axis_F[i],
                damping=drakes.default_damping_vector()[0],
                armature=_armature(plant, joint),
                range=[lower, upper] if np.isfinite(upper - lower) else [0, 0],
            )


def _inboard_joints(plant: MultibodyPlant) -> Mapping[str, str]:
    """Names of the joints that can move, by those of their child bodies."""
    joints = map(plant.get_joint, plant.GetJointIndices())
    return {
        joint.child_body().name(): joint.name()
        for joint in joints
        if joint.num_velocities() == 1
    }


def _moved(kind: int, axis: np.ndarray, position: float) -> np.ndarray:
    """The transform of a joint at a position, shape (4, 4)."""
    if kind == REVOLUTE:
        turn = RotationMatrix(AngleAxis(position, axis))
        return RigidTransform(turn, np.zeros(3)).GetAsMatrix4()
    return RigidTransform(position * axis).GetAsMatrix4()


def _pose(X: RigidTransform) -> dict[str, np.ndarray]:
    return {
        "pos": X.translation(),
        "quat": X.rotation().ToQuaternion().wxyz(),
    }


def _add_mass(body: mujoco.MjsBody, drakes) -> None:
    """Gives a body its mass; one without mass stays so."""
    inertia = drakes.default_spatial_inertia()
    if not inertia.get_mass() > 0:
        return
    moments = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
    full = moments.CopyToFullMatrix3()
    body.explicitinertial = True
    body.mass, body.ipos = inertia.get_mass(), inertia.get_com()
    body.fullinertia = [
        *np.diag(full),
        *(full[0, 1], full[0, 2], full[1, 2]),
    ]


def _armature(plant: MultibodyPlant, joint: str) -> float:
    """The inertia of a joint's rotor, reflected to the joint."""
    motor = plant.get_joint_actuator(actuator_by_joint(plant)[joint])
    return motor.default_rotor_inertia() * motor.default_gear_ratio() ** 2


def _add_shapes(spec: mujoco.MjSpec, robot: RobotModel) -> None:
    """Adds the collision shapes; links that may overlap have no contact."""
    shapes = read_collision_shapes(robot.description, robot.spheres)
    for i, (link, shape) in enumerate(
        zip(shapes.links, shapes.shapes, strict=True)
    ):
        body = spec.body(link)
        if len(shape.vertices) == 1:
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                pos=shape.vertices[0],
                size=[shape.radius, 0, 0],
            )
            continue
        if len(shape.vertices) == 2 and shape.radius > 0:
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=shape.vertices.ravel(),
                size=[shape.radius, 0, 0],
            )
            continue
        mesh = spec.add_mesh(name=f"shape_{i}")
        mesh.uservert = shape.vertices.ravel()
        # Masses are the links' own.
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name)
    _, apart = possible_pairs(robot, shapes.links)
    for a, b in apart:
        spec.add_exclude(bodyname1=a, bodyname2=b)


def _add_scene(spec: mujoco.MjSpec, scene: PrimitiveScene | None) -> None:
    for primitive in scene.primitives if scene else ():
        if isinstance(primitive, Box):
            kind, size = mujoco.mjtGeom.mjGEOM_BOX, primitive.half_extents
        else:
            kind = mujoco.mjtGeom.mjGEOM_CYLINDER
            size = [primitive.radius, primitive.half_height, 0]
        spec.worldbody.add_geom(type=kind, size=size, **_pose(primitive.X_WP))


def _add_motors(spec: mujoco.MjSpec, motors: Motors) -> None:
    """Adds the dampers that hold the joints to their commanded velocities."""
    for name, d in zip(motors.joints, motors.damping, strict=True):
        motor = spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )
        motor.gainprm[0], motor.biasprm[2] = d, -d
