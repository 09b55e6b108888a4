"""Signed distances to solids at the origin, and their gradients."""

import numpy as np

from remosplat_drake.base.kernels import helper


@helper
def box_distance(x, y, z, size):
    """Computes the signed distance to a box at the origin, and its gradient.

    For a point outside, the closest point is the point clamped to the box. For
    a point inside, it is on the nearest face; if faces are equally near, on
    that of the first axis, at its positive side. `size` contains the half
    extents [m].
    """
    qx, qy, qz = abs(x) - size[0], abs(y) - size[1], abs(z) - size[2]
    sx = 1.0 if x >= 0 else -1.0
    sy = 1.0 if y >= 0 else -1.0
    sz = 1.0 if z >= 0 else -1.0
    if qx <= 0 and qy <= 0 and qz <= 0:
        if qx >= qy and qx >= qz:
            return qx, sx, 0.0, 0.0
        if qy >= qz:
            return qy, 0.0, sy, 0.0
        return qz, 0.0, 0.0, sz
    vx, vy, vz = max(qx, 0.0) * sx, max(qy, 0.0) * sy, max(qz, 0.0) * sz
    d = np.sqrt(vx * vx + vy * vy + vz * vz)
    return d, vx / d, vy / d, vz / d


@helper
def cylinder_distance(x, y, z, size):
    """Computes the signed distance to a cylinder along z, and its gradient.

    The cylinder is centred at the origin; `size` contains radius and half
    height [m]. For a point inside that is equally near to the lateral surface
    and to an end, the closest point is on the lateral surface. For a point on
    the axis, the radial direction is x.
    """
    rho = np.sqrt(x * x + y * y)
    ux, uy = (x / rho, y / rho) if rho > 1e-12 else (1.0, 0.0)
    sz = 1.0 if z >= 0 else -1.0
    q_radial, q_axial = rho - size[0], abs(z) - size[2]
    if q_radial <= 0 and q_axial <= 0:
        if q_radial >= q_axial:
            return q_radial, ux, uy, 0.0
        return q_axial, 0.0, 0.0, sz
    v_radial, v_axial = max(q_radial, 0.0), max(q_axial, 0.0)
    d = np.sqrt(v_radial * v_radial + v_axial * v_axial)
    radial = v_radial / d
    return d, radial * ux, radial * uy, v_axial / d * sz
