"""Joint torques of a motion: recursive Newton-Euler equations, in a kernel.

Twists and wrenches of all bodies are expressed in W about its origin, so they
add up along a chain without a change of reference point (Featherstone, Rigid
Body Dynamics Algorithms, 2008).
"""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointActuator

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.base.vectors import cross, dot, set_vector
from remosplat_drake.robot.kinematics import (
    FIXED,
    REVOLUTE,
    KinematicTree,
    body_poses,
)

_GRAVITY = 9.81
"""Acceleration of free fall, along the negative z axis of W [m/s^2]."""


class MassArrays(NamedTuple):
    """Masses of the b bodies of a `KinematicTree`, and of its joints' motors.

    Attributes:
        mass: Masses, shape (b,) [kg].
        p_BBcm: Centres of mass in their bodies, shape (b, 3) [m].
        I_BBcm: Rotational inertias about the centres of mass, in their bodies,
            shape (b, 3, 3) [kg m^2].
        rotor: Rotor inertias reflected to the joints, shape (n_q,) [kg m^2,
            kg].
        damping: Viscous friction of the joints, shape (n_q,) [N m s/rad,
            N s/m].
    """

    mass: np.ndarray
    p_BBcm: np.ndarray
    I_BBcm: np.ndarray
    rotor: np.ndarray
    damping: np.ndarray

    @staticmethod
    def read(
        plant: MultibodyPlant, tree: KinematicTree, joint_names: list[str]
    ) -> "Packed[MassArrays]":
        """Reads the masses from a finalized plant.

        Args:
            plant: A plant with the robot alone.
            tree: The robot's tree.
            joint_names: Names of the joints in the order of q.
        """
        b, n_q = len(tree.names), len(joint_names)
        arrays = MassArrays(
            *(np.zeros(b), np.zeros((b, 3)), np.zeros((b, 3, 3))),
            *(np.zeros(n_q), np.zeros(n_q)),
        )
        for index in range(1, plant.num_bodies()):
            body = plant.get_body(BodyIndex(index))
            i, M_BBo = tree.index(body.name()), body.default_spatial_inertia()
            if not M_BBo.get_mass() > 0.0:
                continue
            at_Bcm = M_BBo.Shift(M_BBo.get_com()).CalcRotationalInertia()
            arrays.mass[i] = M_BBo.get_mass()
            arrays.p_BBcm[i] = M_BBo.get_com()
            arrays.I_BBcm[i] = at_Bcm.CopyToFullMatrix3()
        for j, name in enumerate(joint_names):
            arrays.damping[j] = plant.GetJointByName(name).default_damping()
        for name, motor in motors(plant).items():
            if name in joint_names:
                ratio = motor.default_gear_ratio()
                inertia = ratio**2 * motor.default_rotor_inertia()
                arrays.rotor[joint_names.index(name)] = inertia
        return Packed(arrays)


def motors(plant: MultibodyPlant) -> dict[str, JointActuator]:
    """Returns a plant's actuators by the names of their joints.

    Args:
        plant: A finalized plant.
    """
    indices = plant.GetJointActuatorIndices()
    found = map(plant.get_joint_actuator, indices)
    return {motor.joint().name(): motor for motor in found}


@kernel(returns=reals(3))
def inverse_dynamics(tree, masses, q, v, a):
    """Computes the joint torques of motions, including gravity.

    Args:
        tree: The `TreeArrays`.
        masses: The `MassArrays`.
        q: Configurations, shape (k, n_q) [rad, m].
        v: Rates dq/dt of m motions through each, shape (k, m, n_q) [rad/s,
            m/s].
        a: Their second derivatives, shape (k, m, n_q) [rad/s^2, m/s^2].

    Returns:
        Torques and forces of the joints, shape (k, m, n_q) [N m, N].
    """
    b = len(tree.parent)
    screw, p_WBcm, I_W = np.zeros((b, 6)), np.empty((b, 3)), np.empty((b, 3, 3))
    work = np.zeros((b, 6)), np.zeros((b, 6)), np.zeros((b, 6))
    torque = np.empty(v.shape)
    for k in range(len(q)):
        X_WB, X_WF = body_poses(tree, q[k])
        for i in range(1, b):
            _place_screw(tree.kind[i], tree.axis_F[i], X_WF[i], screw[i])
            if masses.mass[i] > 0.0:
                _place_mass(masses, i, X_WB[i], p_WBcm[i], I_W[i])
        placed = screw, p_WBcm, I_W
        for m in range(v.shape[1]):
            _torques(tree, masses, placed, v[k, m], a[k, m], work, torque[k, m])
    return torque


@helper
def _place_screw(kind, axis_F, X_WF, screw):
    """Fills in a joint's twist in W at a rate of 1; zero of a fixed one."""
    if kind == FIXED:
        return
    for r in range(3):
        along = dot(X_WF[r], axis_F)
        screw[r if kind == REVOLUTE else 3 + r] = along
    if kind == REVOLUTE:
        p_WF = X_WF[0, 3], X_WF[1, 3], X_WF[2, 3]
        set_vector(screw[3:], cross(p_WF, screw[:3]))


@helper
def _place_mass(masses, i, X_WB, p_WBcm, I_W):
    """Fills in a body's centre of mass and its inertia about it in W."""
    p, inertia = masses.p_BBcm[i], masses.I_BBcm[i]
    for r in range(3):
        p_WBcm[r] = X_WB[r, 3] + dot(X_WB[r], p)
        for c in range(3):
            total = 0.0
            for s in range(3):
                total += X_WB[r, s] * dot(inertia[s], X_WB[c])
            I_W[r, c] = total


@helper
def _torques(tree, masses, placed, v, a, work, torque):
    """Fills in the torques of one motion at one configuration."""
    screw, p_WBcm, I_W = placed
    twist, change, wrench = work
    # Gravity is equivalent to an upward acceleration of the world.
    change[0, 5] = _GRAVITY
    for i in range(1, len(tree.parent)):
        parent, j = tree.parent[i], tree.position[i]
        for c in range(6):
            twist[i, c], change[i, c] = twist[parent, c], change[parent, c]
            wrench[i, c] = 0.0
        if j >= 0:
            w, w_s, v_s = _half(twist, parent, 0), *_halves(screw, i)
            turned, moved = cross(w, w_s), cross(w, v_s)
            carried = cross(_half(twist, parent, 3), w_s)
            for c in range(3):
                change[i, c] += turned[c] * v[j]
                change[i, 3 + c] += (moved[c] + carried[c]) * v[j]
            for c in range(6):
                change[i, c] += screw[i, c] * a[j]
                twist[i, c] += screw[i, c] * v[j]
        if masses.mass[i] > 0.0:
            motion = *_halves(twist, i), *_halves(change, i)
            p = p_WBcm[i, 0], p_WBcm[i, 1], p_WBcm[i, 2]
            moment, force = _push(masses.mass[i], p, I_W, i, motion)
            for c in range(3):
                wrench[i, c], wrench[i, 3 + c] = moment[c], force[c]
    for i in range(len(tree.parent) - 1, 0, -1):
        parent, j = tree.parent[i], tree.position[i]
        if j >= 0:
            torque[j] = masses.rotor[j] * a[j] + masses.damping[j] * v[j]
            for c in range(6):
                torque[j] += screw[i, c] * wrench[i, c]
        for c in range(6):
            wrench[parent, c] += wrench[i, c]


@helper
def _push(mass, p, I_W, i, motion):
    """Returns the moment about W's origin and the force of a body's motion."""
    w, v, turn, speed_up = motion
    momentum, needed = _times(I_W, i, w), _times(I_W, i, turn)
    across, spun = cross(w, p), cross(turn, p)
    v = v[0] + across[0], v[1] + across[1], v[2] + across[2]
    curved, gyrated = cross(w, v), cross(w, momentum)
    force = (
        mass * (speed_up[0] + spun[0] + curved[0]),
        mass * (speed_up[1] + spun[1] + curved[1]),
        mass * (speed_up[2] + spun[2] + curved[2]),
    )
    lever = cross(p, force)
    moment = (
        needed[0] + gyrated[0] + lever[0],
        needed[1] + gyrated[1] + lever[1],
        needed[2] + gyrated[2] + lever[2],
    )
    return moment, force


@helper
def _half(six, i, first):
    """Returns three numbers of a row; a slice would be slower."""
    return six[i, first], six[i, first + 1], six[i, first + 2]


@helper
def _halves(six, i):
    """Returns the halves of a row for rotation and for W's origin."""
    return _half(six, i, 0), _half(six, i, 3)


@helper
def _times(I_W, i, w):
    """Returns the product of one of several matrices and a vector."""
    return (
        I_W[i, 0, 0] * w[0] + I_W[i, 0, 1] * w[1] + I_W[i, 0, 2] * w[2],
        I_W[i, 1, 0] * w[0] + I_W[i, 1, 1] * w[1] + I_W[i, 1, 2] * w[2],
        I_W[i, 2, 0] * w[0] + I_W[i, 2, 1] * w[1] + I_W[i, 2, 2] * w[2],
    )
