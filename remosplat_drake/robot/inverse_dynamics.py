"""Joint torques of a motion: recursive Newton-Euler equations, in a kernel.

Twists and wrenches of all bodies are expressed in W about its origin, so they
add up along a chain without a change of reference point (Featherstone, Rigid
Body Dynamics Algorithms, 2008). SIMD lanes contain the values at eight
configurations.
"""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointActuator

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.base.lanes import (
    WIDTH,
    in_all,
    lanes_from,
    write_lanes,
)
from remosplat_drake.base.vectors import cross, dot
from remosplat_drake.robot.kinematics import FIXED, REVOLUTE, KinematicTree
from remosplat_drake.robot.pose_lanes import entry, place_bodies, turned

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
    b, n = len(tree.parent), q.shape[1]
    X_WL, scratch = np.zeros((b, 3, 4, WIDTH)), np.zeros((2, 3, 4, WIDTH))
    placed = (
        np.zeros((b, 6, WIDTH)),
        np.zeros((b, 3, WIDTH)),
        np.zeros((b, 9, WIDTH)),
    )
    work = (
        np.zeros((b, 6, WIDTH)),
        np.zeros((b, 6, WIDTH)),
        np.zeros((b, 6, WIDTH)),
    )
    some_q, some_v = np.empty((n, WIDTH)), np.empty((n, WIDTH))
    some_a, found = np.empty((n, WIDTH)), np.zeros((n, WIDTH))
    torque = np.empty(v.shape)
    for first in range(0, len(q), WIDTH):
        count = min(WIDTH, len(q) - first)
        for lane in range(WIDTH):
            k = first + min(lane, count - 1)
            for j in range(n):
                some_q[j, lane] = q[k, j]
        place_bodies(tree, some_q, X_WL, scratch)
        for i in range(1, b):
            _place_screw(tree, X_WL, i, placed[0])
            if masses.mass[i] > 0.0:
                _place_mass(masses, X_WL, i, placed[1], placed[2])
        for m in range(v.shape[1]):
            for lane in range(WIDTH):
                k = first + min(lane, count - 1)
                for j in range(n):
                    some_v[j, lane], some_a[j, lane] = v[k, m, j], a[k, m, j]
            _write_torques(tree, masses, placed, some_v, some_a, work, found)
            for lane in range(count):
                for j in range(n):
                    torque[first + lane, m, j] = found[j, lane]
    return torque


@helper
def _place_screw(tree, X_WL, i, screw):
    """Writes the twist in W of a joint at a rate of 1; zero if it is fixed."""
    if tree.kind[i] == FIXED:
        return
    X_PF, axis_F, parent = tree.X_PF[i], tree.axis_F[i], tree.parent[i]
    axis_P = dot(X_PF[0], axis_F), dot(X_PF[1], axis_F), dot(X_PF[2], axis_F)
    axis_W = turned(X_WL, parent, axis_P)
    if tree.kind[i] != REVOLUTE:
        _write_three(screw, 6 * i + 3, axis_W)
        return
    p_PF = X_PF[0, 3], X_PF[1, 3], X_PF[2, 3]
    _write_three(screw, 6 * i, axis_W)
    _write_three(screw, 6 * i + 3, cross(_point(X_WL, parent, p_PF), axis_W))


@helper
def _place_mass(masses, X_WL, i, p_WBcm, I_W):
    """Writes the centre of mass of a body, and its inertia about it, in W."""
    p, inertia = masses.p_BBcm[i], masses.I_BBcm[i]
    _write_three(p_WBcm, 3 * i, _point(X_WL, i, (p[0], p[1], p[2])))
    for r in range(3):
        row = entry(X_WL, i, r, 0), entry(X_WL, i, r, 1), entry(X_WL, i, r, 2)
        # The inertia is symmetric.
        across = (
            dot(inertia[0], row),
            dot(inertia[1], row),
            dot(inertia[2], row),
        )
        _write_three(I_W, 9 * i + 3 * r, turned(X_WL, i, across))


@helper
def _point(X_WL, i, p_LP):
    """Returns the position in W of a point on a body, as three lanes."""
    x, y, z = turned(X_WL, i, p_LP)
    return (
        entry(X_WL, i, 0, 3) + x,
        entry(X_WL, i, 1, 3) + y,
        entry(X_WL, i, 2, 3) + z,
    )


@helper
def _write_torques(tree, masses, placed, v, a, work, torque):
    """Writes the torques of a motion at each of eight configurations."""
    screw, p_WBcm, I_W = placed
    twist, change, wrench = work
    # Gravity is equivalent to an upward acceleration of the world.
    write_lanes(change, 5 * WIDTH, in_all(_GRAVITY))
    for i in range(1, len(tree.parent)):
        parent, j = tree.parent[i], tree.position[i]
        w, moving = _three(twist, 6 * parent), _three(twist, 6 * parent + 3)
        turn, push = _three(change, 6 * parent), _three(change, 6 * parent + 3)
        if j >= 0:
            rate, gain = lanes_from(v, j * WIDTH), lanes_from(a, j * WIDTH)
            w_s, v_s = _three(screw, 6 * i), _three(screw, 6 * i + 3)
            carried = _sum(cross(w, v_s), cross(moving, w_s))
            turn = _moved(_moved(turn, cross(w, w_s), rate), w_s, gain)
            push = _moved(_moved(push, carried, rate), v_s, gain)
            w, moving = _moved(w, w_s, rate), _moved(moving, v_s, rate)
        _write_three(twist, 6 * i, w)
        _write_three(twist, 6 * i + 3, moving)
        _write_three(change, 6 * i, turn)
        _write_three(change, 6 * i + 3, push)
        zero = in_all(0.0)
        moment, force = (zero, zero, zero), (zero, zero, zero)
        if masses.mass[i] > 0.0:
            p, motion = _three(p_WBcm, 3 * i), (w, moving, turn, push)
            moment, force = _push(masses.mass[i], p, I_W, i, motion)
        _write_three(wrench, 6 * i, moment)
        _write_three(wrench, 6 * i + 3, force)
    for i in range(len(tree.parent) - 1, 0, -1):
        parent, j = tree.parent[i], tree.position[i]
        moment, force = _three(wrench, 6 * i), _three(wrench, 6 * i + 3)
        if j >= 0:
            rate, gain = lanes_from(v, j * WIDTH), lanes_from(a, j * WIDTH)
            w_s, v_s = _three(screw, 6 * i), _three(screw, 6 * i + 3)
            own = masses.rotor[j] * gain + masses.damping[j] * rate
            found = own + dot(w_s, moment) + dot(v_s, force)
            write_lanes(torque, j * WIDTH, found)
        at = 6 * parent
        _write_three(wrench, at, _sum(_three(wrench, at), moment))
        _write_three(wrench, at + 3, _sum(_three(wrench, at + 3), force))


@helper
def _push(mass, p, I_W, i, motion):
    """Returns the moment about W's origin and the force of a body's motion."""
    w, v, turn, push = motion
    momentum, needed = _times(I_W, i, w), _times(I_W, i, turn)
    spun, curved = cross(turn, p), cross(w, _sum(v, cross(w, p)))
    x, y, z = _sum(_sum(push, spun), curved)
    force = mass * x, mass * y, mass * z
    gyrated, lever = cross(w, momentum), cross(p, force)
    return _sum(_sum(needed, gyrated), lever), force


@helper
def _times(I_W, i, w):
    """Returns the product of one of several matrices and a vector."""
    return (
        dot(_three(I_W, 9 * i), w),
        dot(_three(I_W, 9 * i + 3), w),
        dot(_three(I_W, 9 * i + 6), w),
    )


@helper
def _three(rows, first):
    """Returns three rows of eight numbers as lanes."""
    at = first * WIDTH
    return (
        lanes_from(rows, at),
        lanes_from(rows, at + WIDTH),
        lanes_from(rows, at + 2 * WIDTH),
    )


@helper
def _write_three(rows, first, values):
    """Writes three lanes into rows of eight numbers."""
    write_lanes(rows, first * WIDTH, values[0])
    write_lanes(rows, (first + 1) * WIDTH, values[1])
    write_lanes(rows, (first + 2) * WIDTH, values[2])


@helper
def _sum(a, b):
    """Returns the sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@helper
def _moved(a, b, factor):
    """Returns the sum of a vector and a multiple of another vector."""
    return (
        a[0] + b[0] * factor,
        a[1] + b[1] * factor,
        a[2] + b[2] * factor,
    )
