"""Guidance without look-ahead: when stuck, try the next candidate."""

import dataclasses as dc
from itertools import chain

import numpy as np

from remosplat_drake.controller.guidance.selection import (
    Selection,
    SelectionRule,
    on_the_same_world,
)
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.signals.distance_field import DistanceField

STALL_SPEED = 0.03
"""Speed below which an end effector that has not arrived is stuck [m/s]."""

STALL_TIME = 0.2
"""Time for which the end effector must be that slow to be stuck [s]."""


def cycle_when_stalled(
    rule: SelectionRule,
    selection: Selection,
    *,
    time: float,
    q: np.ndarray,
    u: np.ndarray,
    X_WT: np.ndarray,
    field: DistanceField,
) -> Selection:
    """Keeps the guidance while the end effector moves, else takes the next.

    Args:
        rule: The rule whose candidates are cycled through, tier after tier.
        selection: The selection so far; its `idle_until` is when patience
            with the present guidance ends.
        time: Present time [s].
        q: Measured configuration, shape (n_q,) [rad, m].
        u: Command being executed, shape (n_u,).
        X_WT: Pose of the target T in the world W, shape (4, 4).
        field: The map.
    """
    if not (np.isfinite(q).all() and np.isfinite(X_WT).all()):
        return selection
    selection = on_the_same_world(rule, selection, field.revision, X_WT)
    state = rule.law.robot.state(q)
    speed = np.linalg.norm(state.Jv_WE @ u)
    fresh = not np.isfinite(selection.idle_until)
    if (
        fresh
        or speed >= STALL_SPEED
        or rule.arrived(pose_error(state.X_WE, X_WT))
    ):
        return dc.replace(selection, idle_until=time + STALL_TIME)
    if time < selection.idle_until - 1e-9:
        return selection
    tiers = rule.candidates(q, X_WT, field)
    candidates = list(chain.from_iterable(tiers)) or [rule.start]
    known = selection.guidance in candidates
    i = candidates.index(selection.guidance) + 1 if known else 0
    following = candidates[i % len(candidates)]
    return dc.replace(
        selection,
        guidance=following,
        reason=f"{selection.guidance.name} stalled",
        # A standing robot needs time to pick up speed.
        idle_until=time + 2 * STALL_TIME,
    )
