"""Whether a robot keeps off itself along a motion, in few looks.

Conservative advancement (Mirtich 1996): the distance of two links changes by
no more than a known rate, so that what is far apart now need not be looked at
for a while.
"""

import numpy as np
from numba import njit

from remosplat_drake.robot.kinematics import advance, body_poses, sphere_points


@njit(cache=True)
def keeps_off_itself(robot, motion, pairs, rate, level, blink):
    """Tells whether all pairs of spheres keep their distances on a motion.

    Args:
        robot: The robot as `RobotModel.arrays`.
        motion: Configuration q, the command u that is held for one second,
            and the number of base commands.
        pairs: The p pairs of spheres as four arrays of shape (p,): first and
            second sphere, number of the pair of links, and the allowance by
            which the distance is counted too large [m].
        rate: Bounds on how fast the distances of each of l pairs of links
            change with each entry of the command, shape (l, n_u).
        level: Distance that each pair keeps, shape (p,) [m].
        blink: How far two spheres may move between two looks although they
            are nearer than that to what they keep [m].
    """
    tree, body, p_BS, radius = robot[0], robot[1], robot[2], robot[3]
    q, u, n_base = motion
    first, second, link_pair, allowance = pairs
    speed = np.zeros(len(rate))
    for k in range(len(rate)):
        for c in range(len(u)):
            speed[k] += rate[k, c] * abs(u[c])
    room = np.empty(len(rate))
    time = 0.0
    while True:
        X_WB, _ = body_poses(*tree, advance(q, u, n_base, time))  # pyright: ignore
        p_WS, _ = sphere_points(X_WB, body, p_BS)
        room[:] = np.inf
        for k in range(len(first)):
            i, j = first[k], second[k]
            x = p_WS[i, 0] - p_WS[j, 0]
            y = p_WS[i, 1] - p_WS[j, 1]
            z = p_WS[i, 2] - p_WS[j, 2]
            kept = level[k] - allowance[k] + radius[i] + radius[j]
            # Without a square root, most pairs are seen to be far apart.
            near = kept + room[link_pair[k]]
            if x * x + y * y + z * z >= near * near:
                continue
            found = np.sqrt(x * x + y * y + z * z) - kept
            if found < -1e-9:
                return False
            room[link_pair[k]] = min(room[link_pair[k]], found)
        if time >= 1.0:
            return True
        step = 1.0
        for k in range(len(rate)):
            if speed[k] > 0.0:
                step = min(step, max(room[k], blink) / speed[k])
        time = min(time + step, 1.0)
