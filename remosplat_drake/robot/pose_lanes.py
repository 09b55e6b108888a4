"""Poses at eight configurations at a time, one in each SIMD lane.

An array of k poses has shape (k, 3, 4, 8): rows and columns as in a pose X,
without the last row, which is constant, and the eight configurations.
"""

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lane_angles import sine_and_cosine
from remosplat_drake.base.lanes import WIDTH, in_all, lanes_from, write_lanes
from remosplat_drake.robot.kinematics import FIXED, REVOLUTE

_ENTRIES = 12
"""Number of entries of a pose."""


@helper
def entry(X, i, r, c):
    """Returns an entry of pose i, as lanes."""
    return lanes_from(X, (i * _ENTRIES + 4 * r + c) * WIDTH)


@helper
def write_entry(X, i, r, c, value):
    """Writes lanes into an entry of pose i."""
    write_lanes(X, (i * _ENTRIES + 4 * r + c) * WIDTH, value)


@helper
def turned(X, i, v):
    """Rotates vectors from frame B to frame A, where pose i is X_AB.

    Args:
        X: Array of poses.
        i: Number of the pose.
        v: The vectors, three numbers or lanes.

    Returns:
        The vectors, three lanes.
    """
    x, y, z = v[0], v[1], v[2]
    return (
        entry(X, i, 0, 0) * x + entry(X, i, 0, 1) * y + entry(X, i, 0, 2) * z,
        entry(X, i, 1, 0) * x + entry(X, i, 1, 1) * y + entry(X, i, 1, 2) * z,
        entry(X, i, 2, 0) * x + entry(X, i, 2, 1) * y + entry(X, i, 2, 2) * z,
    )


@helper
def turned_back(X, i, v):
    """Rotates vectors from frame A to frame B, where pose i is X_AB.

    Args:
        X: Array of poses.
        i: Number of the pose.
        v: The vectors, three lanes.

    Returns:
        The vectors, three lanes.
    """
    x, y, z = v
    return (
        entry(X, i, 0, 0) * x + entry(X, i, 1, 0) * y + entry(X, i, 2, 0) * z,
        entry(X, i, 0, 1) * x + entry(X, i, 1, 1) * y + entry(X, i, 2, 1) * z,
        entry(X, i, 0, 2) * x + entry(X, i, 1, 2) * y + entry(X, i, 2, 2) * z,
    )


@helper
def write_identity(X, i):
    """Makes pose i the identity."""
    for r in range(3):
        for c in range(4):
            write_entry(X, i, r, c, in_all(1.0 if r == c else 0.0))


@helper
def compose_by_lanes(X_AB, i, X_BC, X_AC, k):
    """Writes the product of pose i and a pose of shape (4, 4) as pose k."""
    for r in range(3):
        x, y, z = (
            entry(X_AB, i, r, 0),
            entry(X_AB, i, r, 1),
            entry(X_AB, i, r, 2),
        )
        for c in range(3):
            product = x * X_BC[0, c] + y * X_BC[1, c] + z * X_BC[2, c]
            write_entry(X_AC, k, r, c, product)
        moved = x * X_BC[0, 3] + y * X_BC[1, 3] + z * X_BC[2, 3]
        write_entry(X_AC, k, r, 3, entry(X_AB, i, r, 3) + moved)


@helper
def move_by_lanes(kind, axis_F, value, X_F, i, X_M, k):
    """Writes the pose of a joint's moving body, given that of its frame F.

    Args:
        kind: REVOLUTE or PRISMATIC.
        axis_F: Axis in F, a unit vector, shape (3,).
        value: Angles or displacements, as lanes [rad, m].
        X_F: Array of poses that contains that of F as pose i.
        i: See `X_F`.
        X_M: Array of poses; pose k is written.
        k: See `X_M`.
    """
    x, y, z = axis_F[0], axis_F[1], axis_F[2]
    if kind != REVOLUTE:
        for r in range(3):
            a, b, c = (
                entry(X_F, i, r, 0),
                entry(X_F, i, r, 1),
                entry(X_F, i, r, 2),
            )
            write_entry(X_M, k, r, 0, a)
            write_entry(X_M, k, r, 1, b)
            write_entry(X_M, k, r, 2, c)
            along = a * x + b * y + c * z
            write_entry(X_M, k, r, 3, entry(X_F, i, r, 3) + value * along)
        return
    sine, cosine = sine_and_cosine(value)
    for r in range(3):
        # Rodrigues' formula, multiplied by rows of R_WF.
        a, b, c = entry(X_F, i, r, 0), entry(X_F, i, r, 1), entry(X_F, i, r, 2)
        along = (1.0 - cosine) * (a * x + b * y + c * z)
        turned = cosine * a + sine * (b * z - c * y) + along * x
        write_entry(X_M, k, r, 0, turned)
        turned = cosine * b + sine * (c * x - a * z) + along * y
        write_entry(X_M, k, r, 1, turned)
        turned = cosine * c + sine * (a * y - b * x) + along * z
        write_entry(X_M, k, r, 2, turned)
        write_entry(X_M, k, r, 3, entry(X_F, i, r, 3))


@helper
def place_bodies(tree, q, X_WL, scratch):
    """Computes the poses of all bodies, as `body_poses` does.

    Args:
        tree: The `TreeArrays`.
        q: The configurations, shape (n_q, 8) [rad, m].
        X_WL: Output: poses of the b bodies, shape (b, 3, 4, 8).
        scratch: Two poses, which are overwritten, shape (2, 3, 4, 8).
    """
    write_identity(X_WL, 0)
    for i in range(1, len(tree.parent)):
        compose_by_lanes(X_WL, tree.parent[i], tree.X_PF[i], scratch, 0)
        if tree.kind[i] == FIXED:
            compose_by_lanes(scratch, 0, tree.X_MB[i], X_WL, i)
            continue
        value = in_all(tree.offset[i])
        if tree.position[i] >= 0:
            value = lanes_from(q, tree.position[i] * WIDTH)
        kind, axis_F = tree.kind[i], tree.axis_F[i]
        move_by_lanes(kind, axis_F, value, scratch, 0, scratch, 1)
        compose_by_lanes(scratch, 1, tree.X_MB[i], X_WL, i)


@helper
def place_by_lanes(X_WL, body, p_LP, p_WP):
    """Places points that are fixed to bodies.

    Args:
        X_WL: Poses of all bodies, shape (b, 3, 4, 8).
        body: Body of each of n points, shape (n,).
        p_LP: The points in their bodies, shape (n, 3) [m].
        p_WP: Output: the points in W, shape (n, 3, 8) [m].
    """
    for i in range(len(body)):
        for r in range(3):
            at = entry(X_WL, body[i], r, 3)
            for c in range(3):
                at = at + entry(X_WL, body[i], r, c) * p_LP[i, c]
            write_lanes(p_WP, (3 * i + r) * WIDTH, at)
