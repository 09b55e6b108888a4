"""Rehearses planning, so that the first search is as fast as later ones."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.signals.distance_field import DistanceField

_TURN = 0.2
"""Turn of the last joint, from start to end of a path [rad, m]."""


def rehearse(
    planner: MotionPlanner, q: np.ndarray, field: DistanceField
) -> None:
    """Searches a short path, which compiles and loads the code of planning.

    Args:
        planner: The planner.
        q: A configuration, shape (n_q,) [rad, m].
        field: The map. Each kind of map needs its own kernels.
    """
    few = dc.replace(planner.config, seeds=4, checks=8)
    planner = dc.replace(planner, config=few)
    end = q.copy()
    end[-1] += _TURN
    planner.plan(q, planner.robot.end_effector_pose(end), field, 0.0)
    # The search may have ended with a single motion, so trees and shortcuts are
    # also run.
    space = planner.free_space(q, field, 0.0)
    search = planner.search(space, q, end[None])
    search.path_to(end[None])
    search.shortened(np.stack([q, end, q, end]))
