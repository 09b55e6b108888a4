"""Forward kinematics and Jacobians of a whole robot in microseconds (numba).

`KinematicTree` is read from a MultibodyPlant once. The kernels below work only
on arrays, so they take microseconds and need no plant context. Tests compare
them with the plant.

Notation: u is the command: forward speed, speed to the left (omnidirectional
bases only) and yaw rate of the base, then the arm's joint rates. q is the
configuration: x, y, yaw, arm joints. Column j of a Jacobian is a screw: the
axis a_j and a point o_j on it.
"""

import dataclasses as dc
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    Joint,
    PrismaticJoint,
    RevoluteJoint,
    WeldJoint,
)

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2
"""Kinds of joints in `KinematicTree.kind`."""


@dc.dataclass(frozen=True, eq=False)
class KinematicTree:
    """The plant's bodies in topological order, as arrays over b bodies.

    Attributes:
        names: Scoped body names, length b; body 0 is the world.
        parent: Index of the parent body, shape (b,).
        kind: FIXED, REVOLUTE or PRISMATIC inboard joint, shape (b,).
        axis_F: Joint axis in the inboard frame F, shape (b, 3).
        X_PF: Inboard joint frame in the parent body, shape (b, 4, 4).
        X_MB: Body in its outboard joint frame, shape (b, 4, 4).
        position: Index of the joint in q, or -1, shape (b,).
        offset: Constant joint position where `position` is -1, shape (b,).
    """

    names: tuple[str, ...]
    parent: np.ndarray
    kind: np.ndarray
    axis_F: np.ndarray
    X_PF: np.ndarray
    X_MB: np.ndarray
    position: np.ndarray
    offset: np.ndarray

    def index(self, name: str) -> int:
        """Returns the index of the body called `name`.

        Raises:
            RemoSplatError: There is no such body.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise RemoSplatError(
                f"the robot has no link {name!r}; it has: "
                + ", ".join(self.names[1:])
            ) from None

    @cached_property
    def arrays(self) -> Packed["TreeArrays"]:
        """The tree packed for kernels."""
        names = TreeArrays._fields
        return Packed(TreeArrays(*[getattr(self, name) for name in names]))

    def chain(self, body: int) -> list[int]:
        """Returns the bodies from the world (excluded) to `body` (included)."""
        bodies = []
        while body > 0:
            bodies.append(body)
            body = int(self.parent[body])
        return bodies[::-1]

    def with_offsets(
        self, bodies: np.ndarray, position: float
    ) -> "KinematicTree":
        """Returns the tree with other constant positions of locked joints.

        Args:
            bodies: Indices of the bodies that the locked joints carry.
            position: Their position [m, rad].
        """
        offset = self.offset.copy()
        offset[bodies] = position
        offset.flags.writeable = False
        return dc.replace(self, offset=offset)

    def with_body(
        self, name: str, parent: int, X_PB: np.ndarray
    ) -> "KinematicTree":
        """Returns the tree with a further body B, welded to one of its bodies.

        Args:
            name: Name of the body.
            parent: Index of the body P that it is welded to.
            X_PB: Its pose there, shape (4, 4).

        Raises:
            RemoSplatError: There is a body of that name.
        """
        if name in self.names:
            raise RemoSplatError(
                f"the robot has a link {name!r} already; choose another name"
            )
        more = (parent, FIXED, np.zeros(3), X_PB, np.eye(4), -1, 0.0)
        arrays = {}
        for field, value in zip(TreeArrays._fields, more, strict=True):
            before = getattr(self, field)
            row = np.array(value, before.dtype)[None]
            arrays[field] = np.concatenate([before, row])
            arrays[field].flags.writeable = False
        return KinematicTree((*self.names, name), **arrays)


class TreeArrays(NamedTuple):
    """A `KinematicTree`, packed for kernels."""

    parent: np.ndarray
    kind: np.ndarray
    axis_F: np.ndarray
    X_PF: np.ndarray
    X_MB: np.ndarray
    position: np.ndarray
    offset: np.ndarray


def make_kinematic_tree(
    plant: MultibodyPlant, joints: list[str], locked: dict[str, float]
) -> KinematicTree:
    """Reads the kinematic tree off a finalized plant.

    Args:
        plant: A plant of welds, revolute and prismatic joints.
        joints: Joint names in the order of q.
        locked: Constant positions of further joints [rad or m]; a joint that is
            neither in `joints` nor here stays at zero.

    Raises:
        RemoSplatError: A joint has another type, or a name is unknown.
    """
    inboard: dict[int, Joint] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        inboard[int(joint.child_body().index())] = joint
    known = {joint.name() for joint in inboard.values()}
    for name in [*joints, *locked]:
        if name not in known:
            raise RemoSplatError(
                f"the robot has no joint {name!r}; it has: "
                + ", ".join(sorted(known))
            )

    world = int(plant.world_body().index())
    order = [world]
    for body in order:  # The list grows: breadth-first search.
        order += [
            child
            for child, joint in inboard.items()
            if int(joint.parent_body().index()) == body
        ]
    row = {body: i for i, body in enumerate(order)}
    b = len(order)
    tree = KinematicTree(
        names=tuple(plant.get_body(BodyIndex(i)).name() for i in order),
        parent=np.zeros(b, np.int64),
        kind=np.zeros(b, np.int64),
        axis_F=np.zeros((b, 3)),
        X_PF=np.tile(np.eye(4), (b, 1, 1)),
        X_MB=np.tile(np.eye(4), (b, 1, 1)),
        position=np.full(b, -1),
        offset=np.zeros(b),
    )
    for i, body in enumerate(order[1:], start=1):
        joint = inboard[body]
        tree.parent[i] = row[int(joint.parent_body().index())]
        X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
        X_BM = joint.frame_on_child().GetFixedPoseInBodyFrame()
        tree.X_MB[i] = X_BM.inverse().GetAsMatrix4()
        if isinstance(joint, RevoluteJoint):
            tree.kind[i] = REVOLUTE
            tree.axis_F[i] = joint.revolute_axis()
        elif isinstance(joint, PrismaticJoint):
            tree.kind[i] = PRISMATIC
            tree.axis_F[i] = joint.translation_axis()
        elif isinstance(joint, WeldJoint):
            X_PF = X_PF @ joint.X_FM()
        else:
            raise RemoSplatError(
                f"joint {joint.name()!r} is {joint.type_name()!r};"
                " supported: revolute, prismatic, weld"
            )
        tree.X_PF[i] = X_PF.GetAsMatrix4()
        if joint.name() in joints:
            tree.position[i] = joints.index(joint.name())
        else:
            tree.offset[i] = locked.get(joint.name(), 0.0)
    for field in dc.fields(tree):
        value = getattr(tree, field.name)
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return tree


@kernel(linked=True)
def advance(q, u, n_base, time):
    """Integrates the configuration while u is held constant, exactly.

    A base moves on an arc. The chord is v t sinc(omega t / 2), with v rotated
    by the heading at half time. An omnidirectional base (n_base = 3) has a
    speed to the left, a differential one (n_base = 2) has none.

    Args:
        q: Configuration, shape (n_q,).
        u: Command, shape (n_u,).
        n_base: Number of base commands, 3, 2 or 0.
        time: Time for which u is held [s].

    Returns:
        The configuration afterwards, shape (n_q,).
    """
    result = q.copy()
    first = len(q) - len(u)
    for k in range(n_base, len(u)):
        result[first + k] += u[k] * time
    if n_base:
        forward, left = u[0] * time, 0.0
        if n_base == 3:
            left = u[1] * time
        turn = u[n_base - 1] * time
        half_turn = 0.5 * turn
        if half_turn != 0.0:
            sinc = np.sin(half_turn) / half_turn
            forward, left = forward * sinc, left * sinc
        c, s = np.cos(q[2] + half_turn), np.sin(q[2] + half_turn)
        result[0] += forward * c - left * s
        result[1] += forward * s + left * c
        result[2] += turn
    return result


@kernel
def advance_for(q, u, n_base, times):
    """Evaluates `advance` for k times [s]; returns shape (k, n_q)."""
    states = np.empty((len(times), len(q)))
    for k in range(len(times)):
        q_then = advance(q, u, n_base, times[k])
        for c in range(len(q)):
            states[k, c] = q_then[c]
    return states


@kernel
def body_poses(tree, q):
    """Computes the poses of all bodies and inboard joint frames in W.

    Args:
        tree: The `TreeArrays`, packed.
        q: The configuration, shape (n_q,) [rad, m].

    Returns:
        Both kinds of poses, shape (b, 4, 4) each.
    """
    parent, kind, axis_F = tree.parent, tree.kind, tree.axis_F
    X_PF, X_MB = tree.X_PF, tree.X_MB
    position, offset = tree.position, tree.offset
    b = len(parent)
    X_WB = np.zeros((b, 4, 4))
    X_WF = np.zeros((b, 4, 4))
    for k in range(4):
        X_WB[0, k, k] = 1.0
        X_WF[0, k, k] = 1.0
    X_FM = np.zeros((4, 4))
    scratch = np.zeros((4, 4))
    for i in range(1, b):
        compose(X_WB[parent[i]], X_PF[i], X_WF[i])
        if kind[i] == FIXED:
            compose(X_WF[i], X_MB[i], X_WB[i])
            continue
        value = q[position[i]] if position[i] >= 0 else offset[i]
        joint_pose(kind[i], axis_F[i], value, X_FM)
        compose(X_WF[i], X_FM, scratch)
        compose(scratch, X_MB[i], X_WB[i])
    return X_WB, X_WF


@kernel
def body_poses_at(tree, states):
    """Computes the poses of all bodies in W at several configurations.

    Args:
        tree: The `TreeArrays`, packed.
        states: Configurations, shape (m, n_q) [rad, m].

    Returns:
        The poses, shape (m, b, 4, 4).
    """
    X_WBs = np.empty((len(states), len(tree.parent), 4, 4))
    for i in range(len(states)):
        X_WBs[i], _ = body_poses(tree, states[i])  # pyright: ignore
    return X_WBs


@kernel(linked=True)
def compose(X_AB, X_BC, X_AC):
    """Writes the product of two poses, shape (4, 4) each, into an array."""
    for r in range(3):
        for c in range(4):
            total = X_AB[r, 3] if c == 3 else 0.0
            for k in range(3):
                total += X_AB[r, k] * X_BC[k, c]
            X_AC[r, c] = total
    X_AC[3, 0] = X_AC[3, 1] = X_AC[3, 2] = 0.0
    X_AC[3, 3] = 1.0


@helper
def copy_poses(X, Y):
    """Writes n poses, shape (n, 4, 4), into another array of them."""
    for i in range(len(X)):
        for r in range(4):
            for c in range(4):
                Y[i, r, c] = X[i, r, c]


@kernel(linked=True)
def joint_pose(kind, axis, value, X):
    """Writes the pose X_FM of a revolute or a prismatic joint.

    Args:
        kind: REVOLUTE or PRISMATIC.
        axis: Axis in F, a unit vector, shape (3,).
        value: Angle or displacement [rad, m].
        X: The pose, shape (4, 4), filled in.
    """
    for r in range(4):
        for c in range(4):
            X[r, c] = 0.0
    X[3, 3] = 1.0
    if kind == PRISMATIC:
        for k in range(3):
            X[k, k] = 1.0
            X[k, 3] = axis[k] * value
        return
    s, c = np.sin(value), np.cos(value)
    x, y, z = axis[0], axis[1], axis[2]
    v = 1.0 - c
    X[0, 0] = c + x * x * v
    X[0, 1] = x * y * v - z * s
    X[0, 2] = x * z * v + y * s
    X[1, 0] = y * x * v + z * s
    X[1, 1] = c + y * y * v
    X[1, 2] = y * z * v - x * s
    X[2, 0] = z * x * v - y * s
    X[2, 1] = z * y * v + x * s
    X[2, 2] = c + z * z * v


@kernel
def sphere_points(X_WB, body, p_BS):
    """Computes sphere centres p_WS (n, 3) and link orientations R_WL (n, 3, 3).

    Args:
        X_WB: Poses of all bodies, shape (b, 4, 4).
        body: Body of each sphere, shape (n,).
        p_BS: Centres in their body frames, shape (n, 3) [m].
    """
    p_WS = np.empty((len(body), 3))
    R_WL = np.empty((len(body), 3, 3))
    place_points(X_WB, body, p_BS, p_WS, R_WL)
    return p_WS, R_WL


@helper
def place_points(X_WB, body, p_BS, p_WS, R_WL):
    """Writes sphere centres and link orientations into given arrays.

    See `sphere_points`, which allocates the arrays.

    Args:
        X_WB: Poses of all bodies, shape (b, 4, 4).
        body: Body of each sphere, shape (n,).
        p_BS: Centres in their body frames, shape (n, 3) [m].
        p_WS: Filled with the centres in W, shape (n, 3) [m].
        R_WL: Filled with the links' orientations, shape (n, 3, 3).
    """
    for i in range(len(body)):
        X = X_WB[body[i]]
        for r in range(3):
            p_WS[i, r] = X[r, 3]
            for c in range(3):
                R_WL[i, r, c] = X[r, c]
                p_WS[i, r] += X[r, c] * p_BS[i, c]


@kernel
def sphere_points_at(tree, states, state, body, p_BS):
    """Computes sphere centres and link orientations at several configurations.

    Args:
        tree: The `TreeArrays`, packed.
        states: Configurations, shape (k, n_q).
        state: Row of `states` for each sphere, shape (m,).
        body: Body of each sphere, shape (m,).
        p_BS: Centres in their body frames, shape (m, 3) [m].

    Returns:
        Centres p_WS (m, 3) and link orientations R_WL (m, 3, 3).
    """
    m = len(state)
    p_WS = np.empty((m, 3))
    R_WL = np.empty((m, 3, 3))
    first = 0
    while first < m:
        last = first + 1
        while last < m and state[last] == state[first]:
            last += 1
        X_WB, _ = body_poses(tree, states[state[first]])  # pyright: ignore
        p_WS[first:last], R_WL[first:last] = sphere_points(
            X_WB, body[first:last], p_BS[first:last]
        )
        first = last
    return p_WS, R_WL


@kernel
def point_jacobians(a_W, o_W, revolute, moves, body, p_W):
    """Computes the translational Jacobians Jv_WP of n points, (n, 3, n_u).

    Args:
        a_W: Screw axes, shape (n_u, 3).
        o_W: A point on each axis, shape (n_u, 3).
        revolute: Whether the screw rotates, shape (n_u,).
        moves: Whether screw j moves body i, shape (b, n_u).
        body: Body of each point, shape (n,).
        p_W: The points, shape (n, 3) [m].
    """
    n, n_u = len(body), len(a_W)
    J = np.zeros((n, 3, n_u))
    for i in range(n):
        for j in range(n_u):
            if not moves[body[i], j]:
                continue
            if not revolute[j]:
                for k in range(3):
                    J[i, k, j] = a_W[j, k]
                continue
            rx = p_W[i, 0] - o_W[j, 0]
            ry = p_W[i, 1] - o_W[j, 1]
            rz = p_W[i, 2] - o_W[j, 2]
            J[i, 0, j] = a_W[j, 1] * rz - a_W[j, 2] * ry
            J[i, 1, j] = a_W[j, 2] * rx - a_W[j, 0] * rz
            J[i, 2, j] = a_W[j, 0] * ry - a_W[j, 1] * rx
    return J
