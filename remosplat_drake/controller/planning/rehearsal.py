"""Loads the code of planning, so that the first search is as fast as others."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.signals.distance_field import DistanceField

_TURN = 0.2
"""Motion of the last joint from the start to the end of the path [rad, m]."""


def rehearse(
    planner: MotionPlanner, q: np.ndarray, field: DistanceField
) -> None:
    """Plans a short path, which compiles and loads the kernels of planning.

    Args:
        planner: The planner.
        q: A configuration, shape (n_q,) [rad, m].
        field: The map. Each kind of map needs other kernels.
    """
    few = dc.replace(planner.config, seeds=4, checks=8)
    planner = dc.replace(planner, config=few)
    end = q.copy()
    end[-1] += _TURN
    planner.plan(q, planner.robot.end_effector_pose(end), field, 0.0)
    # The search may have ended with a single motion, so the functions of trees
    # and of shortcuts are called, too.
    space = planner.free_space(q, field, 0.0)
    search = planner.search(space, q, end[None])
    search.path_to(end[None])
    search.shortened(np.stack([q, end, q, end]))
