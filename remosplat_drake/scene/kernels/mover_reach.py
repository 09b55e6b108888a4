"""Bounds on future positions of movers: prediction and its error.

The core of a mover is the box inside its rounded shape. Let V and A be the
limits on the speeds and accelerations of its points. The prediction
assumes a constant twist (v, w): the centre moves straight on, and the core
turns at a constant rate. So a predicted point at a distance r from the centre
accelerates by at most |w|^2 r. After a time t, the distance of the true point
from the predicted one is at most

    e_p + min(e_v t + (A + |w|^2 r) t^2 / 2, (V + |v| + |w| r) t)

where e_p and e_v bound the errors of the measured position and velocity. This
bound is the mover's *reach*.
"""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL, named, reals, wholes
from remosplat_drake.base.vectors import norm, rotation
from remosplat_drake.scene.kernels.solid_distance import box_distance

_ROUNDING = 1e-9
"""Bound on rounding errors of distances of up to some metres [m]."""


class MoverArrays(NamedTuple):
    """k movers, as arrays for kernels.

    Attributes:
        half_extents: Half side lengths of their cores, shape (k, 3) [m].
        radius: Radii around the cores, shape (k,) [m].
        R_WM: Orientations at the stamp, shape (k, 3, 3).
        p_WM: Origins of their frames at the stamp, shape (k, 3) [m].
        v_WM: Velocities of these origins in W, shape (k, 3) [m/s].
        w_WM: Angular velocities in W, shape (k, 3) [rad/s].
        bounds: For each mover, the largest speed [m/s], the largest
            acceleration [m/s^2], and the errors of velocity [m/s] and position
            [m], shape (k, 4).
        age: Time since the stamp [s].
    """

    half_extents: np.ndarray
    radius: np.ndarray
    R_WM: np.ndarray
    p_WM: np.ndarray
    v_WM: np.ndarray
    w_WM: np.ndarray
    bounds: np.ndarray
    age: float


class NearMoverArrays(NamedTuple):
    """m pairs of a sphere and a mover that are near each other.

    Attributes:
        sphere: Index of the sphere, shape (m,).
        mover: Index of the mover, shape (m,).
        distance: Lower bound on the distance of the two surfaces until the
            look-ahead time, shape (m,) [m].
        direction_W: The unit vector from the sphere towards the mover in W,
            shape (m, 3).
        closing: The approach speed due to the predicted mover alone, shape (m,)
            [m/s].
    """

    sphere: np.ndarray
    mover: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray
    closing: np.ndarray


@helper
def aged(movers, age) -> MoverArrays:
    """Returns the movers with another age of their measurements.

    Args:
        movers: The `MoverArrays`.
        age: Time since their stamp [s].
    """
    return MoverArrays(
        movers.half_extents,
        movers.radius,
        movers.R_WM,
        movers.p_WM,
        movers.v_WM,
        movers.w_WM,
        movers.bounds,
        age,
    )


@helper
def predicted_speed(movers, j):
    """Bounds the speed of all points of a predicted core [m/s].

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
    """
    far = norm(movers.half_extents[j])
    return norm(movers.v_WM[j]) + norm(movers.w_WM[j]) * far


@helper
def reach(movers, j, time):
    """Bounds the distance of a mover from its prediction [m].

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
        time: Time from now on [s].
    """
    t, bend = movers.age + time, relative_acceleration(movers, j)
    soon = (movers.bounds[j, 2] + 0.5 * bend * t) * t
    late = (movers.bounds[j, 0] + predicted_speed(movers, j)) * t
    return movers.bounds[j, 3] + min(soon, late)


@helper
def relative_acceleration(movers, j):
    """Bounds the acceleration of core points relative to the prediction.

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
    """
    turn = norm(movers.w_WM[j])
    bend = turn * turn * norm(movers.half_extents[j])
    return movers.bounds[j, 1] + bend


@helper
def place_mover(movers, j, time, R_WM, p_WM) -> None:
    """Predicts the pose of a mover's frame.

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
        time: Time from now on [s].
        R_WM: Output: its orientation, shape (3, 3).
        p_WM: Output: its origin, shape (3,) [m].
    """
    t, turn = movers.age + time, norm(movers.w_WM[j])
    for r in range(3):
        p_WM[r] = movers.p_WM[j, r] + movers.v_WM[j, r] * t
        for c in range(3):
            R_WM[r, c] = movers.R_WM[j, r, c]
    if turn * t == 0.0:
        return
    w = movers.w_WM[j]
    axis = (w[0] / turn, w[1] / turn, w[2] / turn)
    R = rotation(axis, turn * t)
    for r in range(3):
        for c in range(3):
            R_WM[r, c] = 0.0
            for k in range(3):
                R_WM[r, c] += R[r, k] * movers.R_WM[j, k, c]


@helper
def core_distance(movers, j, R_WM, p_WM, p_WS):
    """Computes the signed distance of a point from a mover's core.

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
        R_WM: Its orientation, shape (3, 3).
        p_WM: Its origin, shape (3,) [m].
        p_WS: The point, shape (3,) [m].

    Returns:
        The distance [m], and the unit vector towards the core in W, as three
        numbers.
    """
    x, y, z = p_WS[0] - p_WM[0], p_WS[1] - p_WM[1], p_WS[2] - p_WM[2]
    d, gx, gy, gz = box_distance(
        R_WM[0, 0] * x + R_WM[1, 0] * y + R_WM[2, 0] * z,
        R_WM[0, 1] * x + R_WM[1, 1] * y + R_WM[2, 1] * z,
        R_WM[0, 2] * x + R_WM[1, 2] * y + R_WM[2, 2] * z,
        movers.half_extents[j],
    )
    return (
        d,
        -(R_WM[0, 0] * gx + R_WM[0, 1] * gy + R_WM[0, 2] * gz),
        -(R_WM[1, 0] * gx + R_WM[1, 1] * gy + R_WM[1, 2] * gz),
        -(R_WM[2, 0] * gx + R_WM[2, 1] * gy + R_WM[2, 2] * gz),
    )


@helper
def center_distance(movers, j, p_WM, p_WS):
    """Returns a lower bound on the distance of a point from a core [m].

    It is cheaper to compute than `core_distance`, and is below it in spite of
    rounding errors.

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
        p_WM: Its origin, shape (3,) [m].
        p_WS: The point, shape (3,) [m].
    """
    x, y, z = p_WS[0] - p_WM[0], p_WS[1] - p_WM[1], p_WS[2] - p_WM[2]
    away = math.sqrt(x * x + y * y + z * z)
    return (1.0 - _ROUNDING) * away - norm(movers.half_extents[j]) - _ROUNDING


@helper
def closing_speed(movers, j, p_WM, p_WS, far, n_W):
    """Computes the speed at which a predicted core approaches a point [m/s].

    Args:
        movers: The `MoverArrays`.
        j: Index of the mover.
        p_WM: Its origin, shape (3,) [m].
        p_WS: The point, shape (3,) [m].
        far: The point's distance from the core [m].
        n_W: The unit vector towards the core, three numbers.
    """
    v, w = movers.v_WM[j], movers.w_WM[j]
    nx, ny, nz = n_W
    # The core's nearest point, relative to its centre.
    x = p_WS[0] + far * nx - p_WM[0]
    y = p_WS[1] + far * ny - p_WM[1]
    z = p_WS[2] + far * nz - p_WM[2]
    return -(
        nx * (v[0] + w[1] * z - w[2] * y)
        + ny * (v[1] + w[2] * x - w[0] * z)
        + nz * (v[2] + w[0] * y - w[1] * x)
    )


_MOVERS = named(MoverArrays, *map(reals, (2, 1, 3, 2, 2, 2, 2)), REAL)
_NEAR = named(
    NearMoverArrays, wholes(1), wholes(1), reals(1), reals(2), reals(1)
)


@kernel(returns=_MOVERS)
def moved_on(movers, time, longest) -> MoverArrays:
    """Predicts the movers' measured state at a later time.

    The movers keep their twists for `longest`, and rest afterwards. Age and
    error bounds of their measurements do not change.

    Args:
        movers: The `MoverArrays`.
        time: Time from now on [s].
        longest: Time for which they keep their twists [s].
    """
    k = len(movers.radius)
    R_WM, p_WM = np.empty((k, 3, 3)), np.empty((k, 3))
    v_WM, w_WM = movers.v_WM.copy(), movers.w_WM.copy()
    for j in range(k):
        # `place_mover` later adds the motion during their age.
        then = min(time, longest) - movers.age
        place_mover(movers, j, then, R_WM[j], p_WM[j])
        if time > longest:
            for r in range(3):
                v_WM[j, r] = w_WM[j, r] = 0.0
    return MoverArrays(
        movers.half_extents.copy(),
        movers.radius.copy(),
        R_WM,
        p_WM,
        v_WM,
        w_WM,
        movers.bounds.copy(),
        movers.age,
    )


@kernel(returns=_NEAR)
def near_movers(movers, p_WS, radius, within, by) -> NearMoverArrays:
    """Finds the movers that may be near spheres within a look-ahead time.

    Args:
        movers: The `MoverArrays`.
        p_WS: Centres of n spheres in W, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].
        within: Pairs at or beyond this distance are left out [m].
        by: Look-ahead time [s], at which the movers' reach is evaluated.
    """
    n, k = len(p_WS), len(movers.radius)
    sphere, mover = np.empty(n * k, np.int64), np.empty(n * k, np.int64)
    distance, closing = np.empty(n * k), np.empty(n * k)
    direction_W = np.empty((n * k, 3))
    R_WM, p_WM = np.empty((3, 3)), np.empty(3)
    m = 0
    for j in range(k):
        place_mover(movers, j, 0.0, R_WM, p_WM)
        grown = movers.radius[j] + reach(movers, j, by)
        for i in range(n):
            least = center_distance(movers, j, p_WM, p_WS[i])
            if least - grown - radius[i] >= within:
                continue
            far, nx, ny, nz = core_distance(movers, j, R_WM, p_WM, p_WS[i])
            found = far - grown - radius[i]
            if found >= within:
                continue
            n_W = nx, ny, nz
            closing[m] = closing_speed(movers, j, p_WM, p_WS[i], far, n_W)
            sphere[m], mover[m], distance[m] = i, j, found
            direction_W[m, 0] = nx
            direction_W[m, 1] = ny
            direction_W[m, 2] = nz
            m += 1
    return NearMoverArrays(
        sphere[:m], mover[:m], distance[:m], direction_W[:m], closing[:m]
    )


@helper
def is_retreat(depth, touching, ahead, aside) -> bool:
    """Returns whether a sphere moves away from all contacts with a mover.

    The core may be anywhere within its reach of the predicted core. These
    places form a convex set. Let h be the distance of the sphere's centre from
    this set, and n the direction to it. Then all points of the core are at
    least h away from the centre, measured along n. A core point in contact is
    at most R away from the centre, and so at most sqrt(R^2 - h^2) away
    perpendicular to n. A motion of the sphere by -a along n and by b
    perpendicular to n moves away from all such points if a h >= b sqrt(R^2 -
    h^2).

    Args:
        depth: h [m].
        touching: R, the sum of the radii of sphere and mover [m].
        ahead: The sphere's motion along n [m].
        aside: Its motion perpendicular to n, at least 0 [m].
    """
    if depth <= 0.0 or ahead >= 0.0:
        return False
    if depth >= touching:
        return True
    across = math.sqrt(touching * touching - depth * depth)
    return -ahead * depth >= aside * across
