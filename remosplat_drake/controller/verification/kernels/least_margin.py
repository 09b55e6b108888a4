"""Kernel that finds the least margin of the protective separation distance."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL
from remosplat_drake.robot.robot_arrays import add_rate
from remosplat_drake.scene.kernels.mover_reach import (
    center_distance,
    closing_speed,
    core_distance,
    place_mover,
    predicted_speed,
    relative_acceleration,
)


@kernel(returns=REAL)
def least_margin(robot, state, movers, u, monitoring, tube):
    """Finds the pair of a sphere and a mover with the least margin.

    The margin is the distance minus the protective separation distance S_p.
    `protective_separation.py` computes the same in NumPy, and defines the
    terms.

    Args:
        robot: The `RobotArrays`.
        state: The `StateArrays`.
        movers: The `MoverArrays`.
        u: The command, shape (n_u,).
        monitoring: The attributes of a `Monitoring`, in their order.
        tube: Bound Z_r of the position error of each sphere, shape (n,) [m].

    Returns:
        The indices of the sphere and the mover (-1 if there are no movers),
        their distance [m], and their S_p [m].
    """
    separation, reaction, braking, braking_way = monitoring
    now, way = reaction + braking, reaction + braking_way
    since = now + movers.age
    fastest = _fastest(robot, u)
    sphere, mover, distance, needed = -1, -1, 0.0, 0.0
    least = np.inf
    R_WM, p_WM = np.empty((3, 3)), np.empty(3)
    for j in range(len(movers.radius)):
        place_mover(movers, j, 0.0, R_WM, p_WM)
        speed = predicted_speed(movers, j)
        pushed = 0.5 * relative_acceleration(movers, j) * since**2
        late = movers.bounds[j, 0] * since + speed * movers.age
        error = movers.bounds[j, 3] + movers.bounds[j, 2] * since
        most = min(speed * now + pushed, late) + fastest * way
        for i in range(len(tube)):
            radii = movers.radius[j] + robot.radius[i]
            kept = separation + error + tube[i]
            p_WS = state.p_WS[i]
            nearest = center_distance(movers, j, p_WM, p_WS) - radii
            if nearest - most - kept >= least:
                continue
            far, nx, ny, nz = core_distance(movers, j, R_WM, p_WM, p_WS)
            n_W = nx, ny, nz
            closing = closing_speed(movers, j, p_WM, p_WS, far, n_W)
            coming = min(max(closing, 0.0) * now + pushed, late)
            approach = max(_rate(robot, state, i, n_W, u), 0.0)
            required = coming + approach * way + kept
            if far - radii - required < least:
                least = far - radii - required
                sphere, mover, distance, needed = i, j, far - radii, required
    return sphere, mover, distance, needed


@helper
def _fastest(robot, u):
    """Returns bounds of the speeds of all spheres for a command [m/s]."""
    fastest = 0.0
    for i in range(len(robot.radius)):
        speed = 0.0
        for j in range(len(u)):
            speed += robot.jacobian_bound[i, j] * abs(u[j])
        fastest = max(fastest, speed)
    return fastest


@helper
def _rate(robot, state, i, n_W, u):
    """Returns the speed of a sphere along a direction for a command [m/s]."""
    row, rate = np.zeros(len(u)), 0.0
    body, p_WS = robot.body_S[i], state.p_WS[i]
    add_rate(robot, state, body, p_WS, n_W, 1.0, row)
    for j in range(len(u)):
        rate += row[j] * u[j]
    return rate
