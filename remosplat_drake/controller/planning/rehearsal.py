"""Rehearse planning, so that the first path is found as soon as others."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.signals.distance_field import DistanceField

_TURN = 0.2
"""Turn of the last joint, from start to end of a path [rad, m]."""


def rehearse(
    planner: MotionPlanner, q: np.ndarray, field: DistanceField
) -> None:
    """Searches a short path, so that its code is loaded, or compiled first.

    Args:
        planner: The planner.
        q: A configuration, shape (n_q,) [rad, m].
        field: The map. Kernels are loaded for each kind, since they query it in
            compiled code.
    """
    few = dc.replace(planner.config, seeds=4, checks=8)
    planner = dc.replace(planner, config=few)
    end = q.copy()
    end[-1] += _TURN
    planner.plan(q, planner.robot.end_effector_pose(end), field, 0.0)
    # A single motion may have led there: trees and shortcuts come on top.
    space = planner.free_space(q, field, 0.0)
    search = planner.search(space, q, end[None])
    search.path_to(end[None])
    search.shortened(np.stack([q, end, q, end]))
