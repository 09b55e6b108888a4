"""Whether a robot keeps off itself along a motion, in few looks.

Conservative advancement (Mirtich 1996): the distance of two links changes by
no more than a known rate, so that what is far apart now need not be looked at
for a while.
"""

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.robot.kinematics import advance, body_poses
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    centers_in_world,
    distance_beyond,
    least_distance,
)


@kernel
def keeps_off_itself(tree, motion, own, level, blink):
    """Tells whether all pairs of shapes keep their distances on a motion.

    Args:
        tree: The `TreeArrays`, packed.
        motion: Configuration q, the command u that is held for one second,
            and the number of base commands.
        own: The pairs as `SelfClearance.arrays`.
        level: Distance that each pair keeps, shape (k,) [m].
        blink: How far two shapes may move between two looks although they are
            nearer than that to what they keep [m].
    """
    pairs, rate = own.pairs, own.rate
    first, second, start = pairs.first, pairs.second, pairs.start
    allowance, boxes = pairs.allowance, pairs.boxes
    shapes, link_boxes = pairs.shapes, pairs.link_boxes
    q, u, n_base = motion
    speed = np.zeros(len(rate))
    for link in range(len(rate)):
        for c in range(len(u)):
            speed[link] += rate[link, c] * abs(u[c])
    work = make_work()
    time = 0.0
    while True:
        X_WL, _ = body_poses(tree, advance(q, u, n_base, time))
        p_WC = centers_in_world(shapes, X_WL)
        p_WL = centers_in_world(link_boxes, X_WL)
        step = 1.0 - time
        for link in range(len(rate)):
            if speed[link] == 0.0:
                continue
            a, b = boxes[link]
            apart = least_distance(link_boxes, X_WL, p_WL, a, b)
            for k in range(start[link], start[link + 1]):
                kept = level[k] - allowance[k]
                # More room than the rest of the motion needs is not measured.
                enough = kept + step * speed[link]
                if apart >= enough:
                    continue
                pair = first[k], second[k]
                room = -kept + distance_beyond(
                    shapes, X_WL, p_WC, pair, enough, work
                )
                if room < -1e-9:
                    return False
                step = min(step, max(room, blink) / speed[link])
        if time >= 1.0:
            return True
        time = min(time + step, 1.0)
