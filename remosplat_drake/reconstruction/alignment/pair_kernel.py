r"""Point-to-plane residuals of pairs of views, and their normal equations.

A sampled point p of view a lies on the plane n . q = d that view b has at the
pixel where it sees p. With depths s z + o in place of the measured z, and rays
r = (x, y, 1) of the two pixels,

    s e = n_W . (p_W - p_WB) - (s d + o n . r),
    p_W = p_WA + R_WA r_A (s z + o).

Residuals are in units of the sensor: a smaller world has smaller ones, and
would fit better and better. Every view errs by a rotation vector theta_W about
its own centre and a translation t_W of it, so

    s de/dtheta_A = (p_W - p_WA) x n,   s de/dt_A = n = -s de/dt_B,
    s de/dtheta_B = -(p_W - p_WB) x n,
    de/dtheta_B = -de/dtheta_A + (p_WB - p_WA) x de/dt_A:

a pair knows of its relative pose only. Eight numbers an equation will do: the
derivatives by theta_A, t_A, s and o; `pair_expansion` has the others.

`pair_reference` computes the same slowly and readably.
"""

import numpy as np

from remosplat_drake.base.kernels import numpy_helper, numpy_kernel

UNKNOWNS = 8
"""theta_A, t_A, s, o."""

VALUES = 14
"""Numbers that `associate` has for each point."""

NEAR = 0.02
"""Least depth at which a view sees a point [m]."""

FLOOR = 1e-4
"""Least standard deviation of a residual: what no model of noise has [m]."""


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


@numpy_kernel
def associate(stack, pose, scale, offset, a, b, i, gate, least_cosine, out):
    """Compares point i of view a with view b.

    Args:
        stack: The `ViewStack`.
        pose: Poses X_WC, shape (n, 3, 4).
        scale: Factor s of measured depths.
        offset: Offset o that is added to them [m].
        a: Index of the point's view.
        b: Index of the view that it is compared with.
        i: Index of the point.
        gate: Largest residual [m].
        least_cosine: Least cosine between the two normals.
        out: Receives the residual [m], its standard deviation as far as known
            [m], the derivatives by theta_A, t_A, s, o, the point from A's
            centre in W [m], and the square of the difference of the views'
            normals, shape (`VALUES`,).

    Returns:
        Whether view b has a like surface there.
    """
    depth = stack.point[a, i, 2]
    stretch = scale + offset / depth
    ax, ay, az = _turned(
        pose[a],
        stack.point[a, i, 0] * stretch,
        stack.point[a, i, 1] * stretch,
        depth * stretch,
    )
    x, y, z = _turned_back(
        pose[b],
        ax + pose[a, 0, 3] - pose[b, 0, 3],
        ay + pose[a, 1, 3] - pose[b, 1, 3],
        az + pose[a, 2, 3] - pose[b, 2, 3],
    )
    if z <= NEAR:
        return False
    x, y = x / z, y / z
    px, py, pz, d = _plane_at(stack, b, x, y)
    slope = px * x + py * y + pz  # n . r
    if d == 0 or slope > -1e-2:
        return False
    e = z * slope - (scale * d + offset * slope)
    measured = d / slope
    if abs(e) > gate or abs(z - measured) > 3 * gate + 0.02:
        return False
    nx, ny, nz = _turned(pose[b], px, py, pz)
    mx, my, mz = _turned(
        pose[a],
        stack.normal[a, i, 0],
        stack.normal[a, i, 1],
        stack.normal[a, i, 2],
    )
    alike = nx * mx + ny * my + nz * mz
    if alike < least_cosine:
        return False
    arm = nx * ax + ny * ay + nz * az
    own = arm / stretch * depth * stack.deviation[a]
    other = d * measured * stack.deviation[b]
    out[0] = e / scale
    out[1] = np.sqrt(own * own + other * other + FLOOR * FLOOR)
    out[2] = (ay * nz - az * ny) / scale
    out[3] = (az * nx - ax * nz) / scale
    out[4] = (ax * ny - ay * nx) / scale
    out[5], out[6], out[7] = nx / scale, ny / scale, nz / scale
    out[8] = (arm / stretch - d - e / scale) / scale
    out[9] = (arm / (stretch * depth) - slope) / scale
    out[10], out[11], out[12] = ax, ay, az
    out[13] = max(2 * (1 - alike), 0.0)
    return True


@numpy_kernel
def pair_residuals(
    stack, pose, scale, offset, pairs, gate, least_cosine, stride, out
):
    """Writes the residuals of pairs and their deviations.

    Args:
        stack: The `ViewStack`.
        pose: Poses X_WC, shape (n, 3, 4).
        scale: Factor of measured depths.
        offset: Offset that is added to them [m].
        pairs: Indices of views (a, b), shape (m, 2).
        gate: Largest residual [m].
        least_cosine: Least cosine between the two normals.
        stride: Every so many points are compared.
        out: Receives the residual and its standard deviation of every point
            of a in b and of b in a, shape (m, 2, s / stride, 2) [m]; NaN where
            there is none.
    """
    values = np.empty(VALUES)
    for k in range(len(pairs)):
        out[k] = np.nan
        for side in range(2):
            a, b = pairs[k, side], pairs[k, 1 - side]
            for i in range(0, stack.count[a], stride):
                if associate(
                    stack, pose, scale, offset, a, b, i, gate, least_cosine,
                    values,
                ):  # fmt: skip
                    out[k, side, i // stride, 0] = values[0]
                    out[k, side, i // stride, 1] = values[1]


@numpy_kernel
def pair_equations(
    stack, pose, scale, offset, pairs, gate, least_cosine, spread, width,
    H, g, tilts, count,
):  # fmt: skip
    """Sums normal equations H x = -g of each pair over both directions.

    A residual e of deviation sigma has the weight of Geman and McClure (1985),
    1 / ((1 + (e / c)^2)^2 sigma^2) with c = 3 sigma, and sigma scaled by
    `spread` but at least a third of `width`.

    Args:
        stack: The `ViewStack`.
        pose: Poses X_WC, shape (n, 3, 4).
        scale: Factor of measured depths.
        offset: Offset that is added to them [m].
        pairs: Indices of views (a, b), shape (m, 2).
        gate: Largest residual [m].
        least_cosine: Least cosine between the two normals.
        spread: Factor of the residuals' deviations.
        width: Least width of the robust weight [m].
        H: Receives the matrices, shape (m, 8, 8); see `UNKNOWNS`.
        g: Receives the gradients, shape (m, 8).
        tilts: Receives what the noise of the normals' direction adds to the
            matrices, shape (m, 8, 8): that of view b's image, or by how much
            the two views' normals differ, if that is more.
        count: Receives numbers of residuals, shape (m,).
    """
    value = np.empty(VALUES)
    for k in range(len(pairs)):
        H[k] = 0
        g[k] = 0
        tilts[k] = 0
        count[k] = 0
        ex = pose[pairs[k, 1], 0, 3] - pose[pairs[k, 0], 0, 3]
        ey = pose[pairs[k, 1], 1, 3] - pose[pairs[k, 0], 1, 3]
        ez = pose[pairs[k, 1], 2, 3] - pose[pairs[k, 0], 2, 3]
        for side in range(2):
            a, b = pairs[k, side], pairs[k, 1 - side]
            usual = stack.tilt[b] ** 2
            for point in range(stack.count[a]):
                if not associate(
                    stack, pose, scale, offset, a, b, point, gate, least_cosine,
                    value,
                ):  # fmt: skip
                    continue
                if side == 1:
                    # Derivatives by the first view's pose, not by this one's.
                    value[2] += ey * value[7] - ez * value[6]
                    value[3] += ez * value[5] - ex * value[7]
                    value[4] += ex * value[6] - ey * value[5]
                    for j in range(2, 8):
                        value[j] = -value[j]
                    value[10] += ex
                    value[11] += ey
                    value[12] += ez
                sigma = max(spread * value[1], width / 3)
                c = 3 * sigma
                q = 1 + (value[0] / c) ** 2
                w = 1 / (q * q * sigma * sigma)
                for j in range(8):
                    v = w * value[2 + j]
                    g[k, j] += v * value[0]
                    for i in range(j, 8):
                        H[k, j, i] += v * value[2 + i]
                _add_tilt(w * max(usual, value[13]), scale, value, tilts[k])
                count[k] += 1
        for j in range(8):
            for i in range(j):
                H[k, j, i] = H[k, i, j]
                tilts[k, j, i] = tilts[k, i, j]


@numpy_helper
def _add_tilt(w, scale, value, tilts):
    """Adds w (G G^T - J J^T), the upper half, with J = G n, G = ([p] x, 1)."""
    x, y, z = value[10], value[11], value[12]
    u = w / (scale * scale)
    tilts[0, 0] += u * (y * y + z * z)
    tilts[1, 1] += u * (x * x + z * z)
    tilts[2, 2] += u * (x * x + y * y)
    tilts[0, 1] -= u * x * y
    tilts[0, 2] -= u * x * z
    tilts[1, 2] -= u * y * z
    tilts[0, 4] -= u * z
    tilts[0, 5] += u * y
    tilts[1, 3] += u * z
    tilts[1, 5] -= u * x
    tilts[2, 3] -= u * y
    tilts[2, 4] += u * x
    for j in range(6):
        if j >= 3:
            tilts[j, j] += u
        for i in range(j, 6):
            tilts[j, i] -= w * value[2 + j] * value[2 + i]
