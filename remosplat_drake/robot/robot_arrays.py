"""A robot and its state, packed for kernels."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import named, reals
from remosplat_drake.robot.kinematics import (
    TreeArrays,
    body_poses,
    compose,
    point_jacobians,
    sphere_points,
)


class RobotArrays(NamedTuple):
    """The data of a robot with n spheres and b bodies, for kernels.

    Attributes:
        tree: The kinematic tree.
        body_S: Body of each sphere, shape (n,).
        p_LS: Centres of the spheres in their links, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].
        hessian_bound: `RobotModel.hessian_bound`.
        ignore_below: Height below which each sphere ignores the scene, shape
            (n,) [m].
        index: Index of each sphere in contact rules, shape (n,).
        jacobian_bound: `RobotModel.jacobian_bound`.
        leading: For each end effector, which spheres move with its arm's last
            joint, shape (e, n), bool.
        body_E: Bodies of the end effectors, shape (e,).
        X_LE: Poses of the end effectors in these bodies, shape (e, 4, 4).
        body_B: Body of the base.
        n_base: Number of base commands, 3, 2 or 0.
        screw_axis_F: Axes of the commands' joints in their inboard frames,
            shape (n_u, 3).
        screw_body: `RobotModel.screw_body`.
        screw_turns: `RobotModel.screw_turns`.
        moves: Whether command j moves body i, shape (b, n_u), bool.
        velocity_limit: `RobotModel.velocity_limit`.
        acceleration_limit: `RobotModel.acceleration_limit`.
        position_lower: `RobotModel.position_lower`.
        position_upper: `RobotModel.position_upper`.
    """

    tree: TreeArrays
    body_S: np.ndarray
    p_LS: np.ndarray
    radius: np.ndarray
    hessian_bound: np.ndarray
    ignore_below: np.ndarray
    index: np.ndarray
    jacobian_bound: np.ndarray
    leading: np.ndarray
    body_E: np.ndarray
    X_LE: np.ndarray
    body_B: int
    n_base: int
    screw_axis_F: np.ndarray
    screw_body: np.ndarray
    screw_turns: np.ndarray
    moves: np.ndarray
    velocity_limit: np.ndarray
    acceleration_limit: np.ndarray
    position_lower: np.ndarray
    position_upper: np.ndarray


class StateArrays(NamedTuple):
    """The data of a configuration, for kernels.

    Attributes:
        q: The configuration, shape (n_q,) [rad, m].
        X_WE: Poses of the e end effectors, shape (e, 4, 4).
        Jv_WE: Their translational Jacobians, shape (e, 3, n_u).
        Jw_WE: Their angular Jacobians, shape (e, 3, n_u).
        p_WS: Centres of the spheres, shape (n, 3) [m].
        R_WL: Orientations of the spheres' links, shape (n, 3, 3).
        X_WL: Poses of all bodies, shape (b, 4, 4).
        a_W: Axes of the commands' screws, shape (n_u, 3).
        o_W: A point on each axis, shape (n_u, 3) [m].
    """

    q: np.ndarray
    X_WE: np.ndarray
    Jv_WE: np.ndarray
    Jw_WE: np.ndarray
    p_WS: np.ndarray
    R_WL: np.ndarray
    X_WL: np.ndarray
    a_W: np.ndarray
    o_W: np.ndarray


STATE = named(StateArrays, *map(reals, (1, 3, 3, 3, 2, 3, 3, 2, 2)))
"""Numba's type of a state."""


@kernel(returns=STATE)
def state_arrays(robot, q):
    """Computes the `StateArrays` of a configuration.

    Args:
        robot: The `RobotArrays`.
        q: The configuration, shape (n_q,) [rad, m].
    """
    X_WL, X_WF = body_poses(robot.tree, q)
    p_WS, R_WL = sphere_points(X_WL, robot.body_S, robot.p_LS)
    n_u, n_E = len(robot.screw_body), len(robot.body_E)
    a_W, o_W = np.empty((n_u, 3)), np.empty((n_u, 3))
    X_WE, p_WE = np.empty((n_E, 4, 4)), np.empty((n_E, 3))
    for i in range(n_E):
        compose(X_WL[robot.body_E[i]], robot.X_LE[i], X_WE[i])
        for r in range(3):
            p_WE[i, r] = X_WE[i, r, 3]
    Jw_WE = np.zeros((n_E, 3, n_u))
    for j in range(n_u):
        X = X_WF[robot.screw_body[j]]
        for r in range(3):
            o_W[j, r] = X[r, 3]
            a_W[j, r] = 0.0
            for c in range(3):
                a_W[j, r] += X[r, c] * robot.screw_axis_F[j, c]
    if robot.n_base:
        for j in range(robot.n_base - 1):  # Forward is the base's x axis.
            for r in range(3):
                a_W[j, r] = X_WL[robot.screw_body[0], r, j]
    for i in range(n_E):
        for j in range(n_u):
            if robot.screw_turns[j] and robot.moves[robot.body_E[i], j]:
                for r in range(3):
                    Jw_WE[i, r, j] = a_W[j, r]
    Jv_WE = point_jacobians(
        a_W, o_W, robot.screw_turns, robot.moves, robot.body_E, p_WE
    )
    return StateArrays(q, X_WE, Jv_WE, Jw_WE, p_WS, R_WL, X_WL, a_W, o_W)


@helper
def add_rate(robot, state, body, p_W, n_W, sign, row):
    """Adds sign n' Jv_WP to a row: the rate of a point along a direction.

    Args:
        robot: The `RobotArrays`.
        state: The `StateArrays`.
        body: Index of the body that the point is fixed to.
        p_W: The point, shape (3,) [m].
        n_W: The direction, shape (3,) or three numbers.
        sign: Factor of the added terms.
        row: The row to change, one entry for each command, shape (n_u,) [m/rad
            or 1].

    Example:
        >>> import remosplat_drake as rs
        >>> import numpy as np
        >>> robot = rs.load_robot("frankie")
        >>> state, row = robot.state(robot.q_home).arrays, np.zeros(robot.n_u)
        >>> body, p_WS = robot.arrays.body_S[0], state.p_WS[0]
        >>> forward_W = np.array([1.0, 0.0, 0.0])
        >>> rs.add_rate(robot.arrays, state, body, p_WS, forward_W, 1.0, row)
        >>> float(row[0])
        1.0
    """
    for j in range(len(row)):
        if not robot.moves[body, j]:
            continue
        a = state.a_W[j]
        x, y, z = a[0], a[1], a[2]
        if robot.screw_turns[j]:
            o = state.o_W[j]
            rx, ry, rz = p_W[0] - o[0], p_W[1] - o[1], p_W[2] - o[2]
            x, y, z = y * rz - z * ry, z * rx - x * rz, x * ry - y * rx
        row[j] += sign * (n_W[0] * x + n_W[1] * y + n_W[2] * z)
