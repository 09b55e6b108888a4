r"""Point-to-plane residuals of pairs of views, and their normal equations.

A sampled point p of view a should lie on the plane n . q = d of view b at the
pixel to which p projects. The errors e_k that all images share displace both
points by B e, see `camera_errors`. The first of these errors is that of the
depth scale s = 1 + e_1. The residual e of the point is

    s e = n_W . (p_W - p_WB) - (d + n . B_B e),
    p_W = p_WA + R_WA (p + B_A e).

The residual is divided by the scale s, since otherwise a smaller world would
have smaller residuals. The error of a view's pose is a rotation vector theta_W
about its centre and a translation t_W of the centre, so

    s de/dtheta_A = (p_W - p_WA) x n,   s de/dt_A = n = -s de/dt_B,
    s de/dtheta_B = -(p_W - p_WB) x n,
    de/dtheta_B = -de/dtheta_A + (p_WB - p_WA) x de/dt_A,
    s de/de_k = n_W . (R_WA b_Ak - R_WB b_Bk).

For the scale (k = 1), e must be subtracted from the right-hand side of the last
equation, because s depends on e_1.

A pair constrains only the relative pose of its views. So the kernel computes 6
+ k derivatives: those with respect to theta_A, t_A and the k shared errors.
`pair_expansion` computes those with respect to theta_B and t_B from them. Each
derivative is n_W . g_j, with a vector g_j.

`pair_reference` is the slow, readable reference.
"""

import numpy as np
from numba import prange

from remosplat_drake.base.kernels import (
    numpy_helper,
    numpy_kernel,
    parallel_kernel,
)
from remosplat_drake.reconstruction.alignment.camera_errors import (
    add_displacements,
)

VALUES = 9
"""Number of values that `associate` writes for each point."""

POSE = 6
"""Number of values of a pose's error, theta and t."""

NEAR = 0.02
"""Least depth of a point in front of a camera that counts as visible [m]."""

FLOOR = 1e-4
"""Least standard deviation of a residual; it allows for unmodelled noise
[m]."""

_TREMBLING = 4
"""Step between the residuals that are used to estimate the effect of noisy
normals."""


@numpy_helper
def _turned(pose, x, y, z):
    """Returns a vector of a camera's frame in W."""
    return (
        pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z,
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z,
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z,
    )


@numpy_helper
def _turned_back(pose, x, y, z):
    """Returns a vector of W in a camera's frame."""
    return (
        pose[0, 0] * x + pose[1, 0] * y + pose[2, 0] * z,
        pose[0, 1] * x + pose[1, 1] * y + pose[2, 1] * z,
        pose[0, 2] * x + pose[1, 2] * y + pose[2, 2] * z,
    )


@numpy_helper
def _plane_at(stack, b, x, y):
    """Returns normal and distance of view b's plane on the ray (x, y, 1).

    The distance is 0 where the view has no plane.
    """
    column = (stack.camera[b, 0] * x + stack.camera[b, 2] - 0.5) / stack.step
    row = (stack.camera[b, 1] * y + stack.camera[b, 3] - 0.5) / stack.step
    if not (
        -0.5 < column < stack.plane.shape[2] - 0.5
        and -0.5 < row < stack.plane.shape[1] - 0.5
    ):
        return 0.0, 0.0, 0.0, 0.0
    plane = stack.plane[b, int(row + 0.5), int(column + 0.5)]
    return float(plane[0]), float(plane[1]), float(plane[2]), float(plane[3])


@numpy_helper
def _displace(stack, view, x, y, z, out):
    """Writes the displacements of a view's point by the shared errors."""
    add_displacements(
        stack.camera[view], stack.height[view], stack.velocity_C[view],
        x, y, z, out,
    )  # fmt: skip


@numpy_kernel
def associate(stack, pose, errors, a, b, i, gate, least_cosine, out, arms):
    """Computes the residual of point i of view a on the surfaces of view b.

    Args:
        stack: The `ViewStack`.
        pose: Poses X_WC, shape (n, 3, 4).
        errors: Errors that all images share, shape (k,): `COUNT` numbers or
            none.
        a: Index of the point's view.
        b: Index of the view that it is compared with.
        i: Index of the point.
        gate: Largest residual [m].
        least_cosine: Least cosine between the two normals.
        out: Output of shape (`VALUES`,): the residual [m], its standard
            deviation due to the known noise [m], the normal n_W, the vector
            from the centre of camera A to the point in W [m], and the square of
            the difference of the views' normals.
        arms: Output: the vectors g_j of the derivatives by the shared errors,
            in W. The array has the shape (2, k, 3); `arms[0]` is the result,
            and `arms[1]` is work space.

    Returns:
        Whether view b shows a surface at the point's pixel that meets both
        limits. If not, the outputs are undefined.
    """
    count = len(errors)
    ax, ay, az = (
        stack.point[a, i, 0],
        stack.point[a, i, 1],
        stack.point[a, i, 2],
    )
    depth = az
    px, py, pz = ax, ay, az
    if count:
        _displace(stack, a, ax / depth, ay / depth, depth, arms[0])
        for k in range(count):
            px += errors[k] * arms[0, k, 0]
            py += errors[k] * arms[0, k, 1]
            pz += errors[k] * arms[0, k, 2]
    px, py, pz = _turned(pose[a], px, py, pz)
    x, y, z = _turned_back(
        pose[b],
        px + pose[a, 0, 3] - pose[b, 0, 3],
        py + pose[a, 1, 3] - pose[b, 1, 3],
        pz + pose[a, 2, 3] - pose[b, 2, 3],
    )
    if z <= NEAR:
        return False
    x, y = x / z, y / z
    lx, ly, lz, d = _plane_at(stack, b, x, y)
    slope = lx * x + ly * y + lz  # n . r
    if d == 0 or slope > -1e-2:
        return False
    measured = d / slope
    e = z * slope - d
    if count:
        _displace(stack, b, x, y, measured, arms[1])
        for k in range(count):
            e -= errors[k] * (
                lx * arms[1, k, 0] + ly * arms[1, k, 1] + lz * arms[1, k, 2]
            )
    if abs(e) > gate or abs(z - measured) > 3 * gate + 0.02:
        return False
    nx, ny, nz = _turned(pose[b], lx, ly, lz)
    mx, my, mz = _turned(
        pose[a],
        stack.normal[a, i, 0],
        stack.normal[a, i, 1],
        stack.normal[a, i, 2],
    )
    alike = nx * mx + ny * my + nz * mz
    if alike < least_cosine:
        return False
    ax, ay, az = _turned(pose[a], ax, ay, depth)
    own = (nx * ax + ny * ay + nz * az) * depth * stack.deviation[a]
    other = d * measured * stack.deviation[b]
    scale = 1.0
    if count:
        scale += errors[0]
        for k in range(count):
            own_arm = _turned(
                pose[a], arms[0, k, 0], arms[0, k, 1], arms[0, k, 2]
            )
            their = _turned(
                pose[b], arms[1, k, 0], arms[1, k, 1], arms[1, k, 2]
            )
            for axis in range(3):
                arms[0, k, axis] = own_arm[axis] - their[axis]
    out[0] = e / scale
    out[1] = np.sqrt(own * own + other * other + FLOOR * FLOOR)
    out[2], out[3], out[4] = nx, ny, nz
    out[5], out[6], out[7] = px, py, pz
    out[8] = max(2 * (1 - alike), 0.0)
    return True


@numpy_kernel
def pair_residuals(stack, pose, errors, pairs, gate, least_cosine, stride, out):
    """Writes the residuals of pairs of views and their standard deviations.

    Args:
        stack: The `ViewStack`.
        pose: Poses X_WC, shape (n, 3, 4).
        errors: Errors that all images share, see `associate`.
        pairs: Indices of views (a, b), shape (m, 2).
        gate: Largest residual [m].
        least_cosine: Least cosine between the two normals.
        stride: Step between the points that are compared.
        out: Output: for every point of a in b, and of b in a, the residual and
            its standard deviation, shape (m, 2, s / stride, 2) [m]; NaN where
            there is no residual.
    """
    values, arms = np.empty(VALUES), np.empty((2, len(errors), 3))
    for k in range(len(pairs)):
        out[k] = np.nan
        for side in range(2):
            a, b = pairs[k, side], pairs[k, 1 - side]
            for i in range(0, stack.count[a], stride):
                if associate(
                    stack, pose, errors, a, b, i, gate, least_cosine,
                    values, arms,
                ):  # fmt: skip
                    out[k, side, i // stride, 0] = values[0]
                    out[k, side, i // stride, 1] = values[1]


@parallel_kernel
def pair_equations(
    stack, pose, errors, pairs, gate, least_cosine, spread, width,
    H, g, tilts, count,
):  # fmt: skip
    """Sums the normal equations H x = -g of each pair of views.

    They include the points of a in b and those of b in a. A residual e with
    standard deviation sigma has the weight of Geman and McClure (1985), 1 / ((1
    + (e / c)^2)^2 sigma^2) with c = 3 sigma, and sigma scaled by `spread` but
    at least a third of `width`.

    Args:
        stack: The `ViewStack`.
        pose: Poses X_WC, shape (n, 3, 4).
        errors: Errors that all images share, see `associate`.
        pairs: Indices of views (a, b), shape (m, 2).
        gate: Largest residual [m].
        least_cosine: Least cosine between the two normals.
        spread: Factor by which the residuals' standard deviations are
            multiplied.
        width: Least width of the robust weight [m].
        H: Receives the matrices, shape (m, 6 + k, 6 + k).
        g: Receives the gradients, shape (m, 6 + k).
        tilts: Output: the part of H that noise in the normals' directions
            causes, shape (m, 6 + k, 6 + k). The assumed noise is that of view
            b's image, or the difference of the two views' normals if it is
            larger.
        count: Receives the number of residuals of each pair, shape (m,).
    """
    for k in prange(len(pairs)):
        _add_pair(
            stack, pose, errors, pairs[k], gate, least_cosine, spread, width,
            H[k], g[k], tilts[k], count[k : k + 1],
        )  # fmt: skip


@numpy_helper
def _add_pair(
    stack, pose, errors, pair, gate, least_cosine, spread, width,
    H, g, tilts, count,
):  # fmt: skip
    """Sums one pair's equations."""
    unknowns = POSE + len(errors)
    value, arms = np.empty(VALUES), np.empty((2, len(errors), 3))
    J, vectors = np.empty(unknowns), np.empty((unknowns, 3))
    scale = 1.0
    if len(errors):
        scale += errors[0]
    H[:], g[:], tilts[:], count[0] = 0, 0, 0, 0
    for side in range(2):
        a, b = pair[side], pair[1 - side]
        usual = stack.tilt[b] ** 2
        for point in range(stack.count[a]):
            if not associate(
                stack, pose, errors, a, b, point, gate, least_cosine,
                value, arms,
            ):  # fmt: skip
                continue
            sign = 1.0 if side == 0 else -1.0
            # Derivatives by the first view's pose, also for the second view's
            # points.
            for axis in range(3):
                value[5 + axis] += pose[a, axis, 3] - pose[pair[0], axis, 3]
            _write_vectors(value, arms[0], sign, vectors)
            for j in range(unknowns):
                J[j] = (
                    value[2] * vectors[j, 0]
                    + value[3] * vectors[j, 1]
                    + value[4] * vectors[j, 2]
                ) / scale
            sigma = max(spread * value[1], width / 3)
            q = 1 + (value[0] / (3 * sigma)) ** 2
            w = 1 / (q * q * sigma * sigma)
            if point % _TREMBLING == 0:
                trembling = _TREMBLING * w * max(usual, value[8])
                _add_tilt(trembling, scale, J, vectors, tilts)
            if len(errors):
                J[POSE] -= value[0] / scale
            for j in range(unknowns):
                v = w * J[j]
                g[j] += v * value[0]
                for i in range(j, unknowns):
                    H[j, i] += v * J[i]
            count[0] += 1
    for j in range(unknowns):
        for i in range(j):
            H[j, i] = H[i, j]
            tilts[j, i] = tilts[i, j]


@numpy_helper
def _write_vectors(value, arms, sign, out):
    """Writes the vectors g_j of a residual's derivatives."""
    px, py, pz = sign * value[5], sign * value[6], sign * value[7]
    out[:POSE] = 0
    out[0, 1], out[0, 2] = -pz, py
    out[1, 0], out[1, 2] = pz, -px
    out[2, 0], out[2, 1] = -py, px
    for axis in range(3):
        out[3 + axis, axis] = sign
    for k in range(len(arms)):
        for axis in range(3):
            out[POSE + k, axis] = arms[k, axis]


@numpy_helper
def _add_tilt(w, scale, J, vectors, tilts):
    """Adds w (G G^T - J J^T), the upper half, with the rows g_j of G."""
    u = w / (scale * scale)
    for j in range(len(J)):
        for i in range(j, len(J)):
            across = (
                vectors[j, 0] * vectors[i, 0]
                + vectors[j, 1] * vectors[i, 1]
                + vectors[j, 2] * vectors[i, 2]
            )
            tilts[j, i] += u * across - w * J[j] * J[i]
