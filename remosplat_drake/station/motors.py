"""Velocity-controlled motors of the dynamic station.

Each joint is held to its commanded velocity by a damper that the contact
solver treats implicitly: torque = d (v_desired - v), never more than the
joint's effort limit. d is the joint's inertia over the time constant, so that
one number serves every joint of every robot. There is no position gain: the
command is a velocity, and a blocked joint must not wind up.
"""

import dataclasses as dc

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuatorIndex, PdControllerGains

from remosplat_drake.errors import FileError
from remosplat_drake.robot.robot_model import RobotModel, add_robot_model
from remosplat_drake.station.hand import HandGeometry

DRIVE_SHARE = 0.8
"""Share of the base's effort that drives forward; the rest holds it sideways,
like the wheels of a differential base, which cannot slip."""


@dc.dataclass(frozen=True, eq=False)
class Motors:
    """The motors of the station's joints: (x, y, yaw), arm, fingers.

    Attributes:
        joints: Joint names, length m.
        damping: Gains d, shape (m,) [N s/m or N m s/rad].
        effort: Effort limits, shape (m,) [N or N m].
    """

    joints: tuple[str, ...]
    damping: np.ndarray
    effort: np.ndarray


def make_motors(
    robot: RobotModel,
    hand: HandGeometry,
    q0: np.ndarray,
    time_constant: float,
    hand_speed: float,
) -> Motors:
    """Sizes the gains from the robot's inertia at q0.

    A finger's damper is so stiff that a finger blocked at full speed pushes
    with its whole effort.

    Raises:
        FileError: A joint has no actuator.
    """
    plant = MultibodyPlant(time_step=0.0)
    add_robot_model(robot.description, plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = plant.GetPositions(context)
    for name, position in zip(robot.joint_names, q0, strict=True):
        q[plant.GetJointByName(name).position_start()] = position
    plant.SetPositions(context, q)
    inertia = np.diag(plant.CalcMassMatrix(context))
    actuators = actuator_by_joint(plant)
    joints = (*robot.joint_names, *hand.joints)
    damping, effort = [], []
    for name in joints:
        if name not in actuators:
            raise FileError(
                robot.description.model_path,
                f"joint {name!r} has no actuator (<transmission>), which the"
                " dynamic station needs",
            )
        actuator = plant.get_joint_actuator(actuators[name])
        M = inertia[plant.GetJointByName(name).velocity_start()]
        effort.append(actuator.effort_limit())
        damping.append(M / time_constant)
        if name in hand.joints and np.isfinite(actuator.effort_limit()):
            finger_speed = hand_speed / len(hand.joints)
            damping[-1] = max(
                damping[-1], actuator.effort_limit() / finger_speed
            )
    return Motors(joints, np.array(damping), np.array(effort))


def set_motor_gains(plant: MultibodyPlant, motors: Motors) -> None:
    """Gives the plant's actuators the motors' gains, before `Finalize`."""
    actuators = actuator_by_joint(plant)
    for name, d in zip(motors.joints, motors.damping, strict=True):
        actuator = plant.get_joint_actuator(actuators[name])
        actuator.set_controller_gains(PdControllerGains(p=0.0, d=d))


def actuator_by_joint(plant: MultibodyPlant) -> dict[str, JointActuatorIndex]:
    """The actuator of each actuated joint."""
    return {
        plant.get_joint_actuator(index).joint().name(): index
        for index in plant.GetJointActuatorIndices()
    }


def held_to_effort(
    desired: np.ndarray | float,
    measured: np.ndarray | float,
    effort: np.ndarray | float,
    damping: np.ndarray | float,
) -> np.ndarray | float:
    """The desired velocity at which a damper pushes with `effort` at most."""
    bound = effort / damping
    return measured + np.clip(desired - measured, -bound, bound)
