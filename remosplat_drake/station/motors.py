"""Computes the gains of the dynamic station's velocity-controlled motors.

The motor of each joint is a damper, torque = d (v_desired - v), limited to the
joint's effort limit. The contact solver treats it implicitly. The gain d is the
inertia of the joint divided by the time constant, so one time constant suits
all joints of all robots. The gain is at least a multiple of the joint's viscous
friction, which would otherwise stop a light joint. There is no position gain,
since the error of a blocked joint would accumulate. As a consequence, the
velocity of a joint under load has the error torque / d. The time constant is
short, so that this error is small.
"""

import dataclasses as dc
from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuatorIndex, PdControllerGains

from remosplat_drake.base.errors import FileError
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.station.hand import (
    HandGeometry,
    finger_joints,
    finger_slices,
)
from remosplat_drake.station.station_config import DynamicStation

_OVER_FRICTION = 100.0
"""A motor's gain is at least this multiple of its joint's viscous friction.
With it, a joint without load is slower than commanded by at most 1 %."""

DRIVE_SHARE = 0.8
"""This fraction of the base's effort limit may drive the base forward. The rest
prevents sideways motion, which the wheels of a real differential base
prevent."""


@dc.dataclass(frozen=True, eq=False)
class Motors:
    """The motors of a dynamic station's joints.

    Attributes:
        joints: Names of the m joints: base (x, y, yaw), arm, fingers.
        damping: Gains d of the motors, shape (m,) [N s/m or N m s/rad].
        drive_error: The desired forward velocity of the base differs from the
            measured one by at most this value [m/s], so that x and y keep some
            effort against sideways motion; infinite for a fixed base.
    """

    joints: tuple[str, ...]
    damping: np.ndarray
    drive_error: float


def make_motors(
    robot: RobotModel,
    hands: Sequence[HandGeometry],
    q0: np.ndarray,
    config: DynamicStation,
) -> Motors:
    """Computes the motors' gains from the robot's inertia and friction.

    The gain of a finger is chosen such that a blocked finger with the commanded
    speed `hand_speed` pushes with its effort limit.

    Args:
        robot: The robot.
        hands: Geometry of the robot's grippers.
        q0: Configuration at which the inertia is computed, shape (n_q,).
        config: Time constant, hand speed and time step of the station.

    Raises:
        FileError: A joint has no actuator.
    """
    plant = MultibodyPlant(time_step=0.0)
    add_robot_model(robot.description, plant)
    plant.Finalize()
    joints = (*robot.joint_names, *finger_joints(hands))
    inertia = _inertia(plant, robot, joints, q0)
    effort = effort_limits(plant, robot, joints)
    friction = np.array(
        [plant.GetJointByName(n).default_damping_vector()[0] for n in joints]
    )
    damping = inertia / config.velocity_time_constant
    damping = np.maximum(damping, _OVER_FRICTION * friction)
    for hand, fingers in zip(
        hands, finger_slices(hands, robot.n_q), strict=True
    ):
        finger_speed = config.hand_speed / len(hand.joints)
        stiff = np.where(np.isfinite(effort), effort, 0.0) / finger_speed
        damping[fingers] = np.maximum(damping, stiff)[fingers]
    drive_error = np.inf
    if robot.n_base:
        # In one step, the force f corrects the velocity error e = f / d + f dt
        # / M.
        f = DRIVE_SHARE * effort[:2].min()
        drive_error = f / damping[0] + f * config.time_step / inertia[0]
    return Motors(joints, damping, float(drive_error))


def _inertia(
    plant: MultibodyPlant,
    robot: RobotModel,
    joints: tuple[str, ...],
    q0: np.ndarray,
) -> np.ndarray:
    """Returns the diagonal of the mass matrix at q0, with rotors, by joint."""
    context = plant.CreateDefaultContext()
    q = plant.GetPositions(context)
    for name, position in zip(robot.joint_names, q0, strict=True):
        q[plant.GetJointByName(name).position_start()] = position
    plant.SetPositions(context, q)
    M = plant.CalcMassMatrix(context)
    return np.diag(M)[
        [plant.GetJointByName(name).velocity_start() for name in joints]
    ]


def effort_limits(
    plant: MultibodyPlant, robot: RobotModel, joints: tuple[str, ...]
) -> np.ndarray:
    """Reads the effort limits of some joints' motors.

    Args:
        plant: The finalized plant with the robot.
        robot: The robot; errors name it.
        joints: Names of the m joints.

    Returns:
        The limits, shape (m,) [N, N m]; infinite for a joint without a limit.

    Raises:
        FileError: A joint has no actuator.
    """
    actuators = actuator_by_joint(plant)
    for name in joints:
        if name not in actuators:
            raise FileError(
                robot.description.model_path,
                f"joint {name!r} has no actuator (<transmission>), which the"
                " dynamic station needs",
            )
    return np.array(
        [plant.get_joint_actuator(actuators[n]).effort_limit() for n in joints]
    )


def set_motor_gains(plant: MultibodyPlant, motors: Motors) -> None:
    """Sets the gains of a plant's actuators to those of the motors.

    Args:
        plant: The plant, before `Finalize`.
        motors: The motors.
    """
    actuators = actuator_by_joint(plant)
    for name, d in zip(motors.joints, motors.damping, strict=True):
        actuator = plant.get_joint_actuator(actuators[name])
        actuator.set_controller_gains(PdControllerGains(p=0.0, d=d))


def actuator_by_joint(plant: MultibodyPlant) -> dict[str, JointActuatorIndex]:
    """Returns the actuators of a plant, keyed by the name of their joint."""
    return {
        plant.get_joint_actuator(index).joint().name(): index
        for index in plant.GetJointActuatorIndices()
    }


def motor_rows(plant: MultibodyPlant, joints: Iterable[str]) -> list[int]:
    """Returns the rows of joints in a plant's net actuation.

    Args:
        plant: The finalized plant.
        joints: Names of the joints, each of which has a motor.
    """
    actuators = actuator_by_joint(plant)
    return [
        plant.get_joint_actuator(actuators[name]).input_start()
        for name in joints
    ]
