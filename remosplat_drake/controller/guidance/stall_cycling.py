"""Guidance without rollouts: if the robot stalls, takes the next candidate."""

import dataclasses as dc
from itertools import chain

import numpy as np

from remosplat_drake.controller.guidance.selection import (
    Selection,
    on_the_same_world,
)
from remosplat_drake.controller.guidance.selection_rule import SelectionRule
from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.target import Target

STALL_SPEED = 0.03
"""Speed below which an end effector that has not arrived counts as stopped
[m/s]."""

STALL_TIME = 0.2
"""Time after which a stopped end effector counts as stalled [s]."""


def cycle_when_stalled(
    rule: SelectionRule,
    selection: Selection,
    *,
    time: float,
    q: np.ndarray,
    u: np.ndarray,
    aim: Aim | Target | np.ndarray,
    field: DistanceField,
    movers: Movers | None = None,
    motion: Motion | None = None,
    payload: Payload | None = None,
) -> Selection:
    """Keeps the guidance while the end effector moves; else takes the next one.

    Args:
        rule: The rule, whose candidates are taken in turn, tier after tier.
        selection: The selection so far; `idle_until` is the time from which the
            robot counts as stalled.
        time: Present time [s].
        q: Measured configuration, shape (n_q,) [rad, m].
        u: Command being executed, shape (n_u,).
        aim: The targets of the end effectors, an `Aim`. A `Target`, or its pose
            X_WT, shape (4, 4), applies to the first end effector.
        field: The map.
        movers: Not used.
        motion: Not used.
        payload: What the robot carries; None for nothing.
    """
    del movers, motion
    rule, aim = rule.holding(payload), Aim.of(aim)
    if not (np.isfinite(q).all() and aim.is_known):
        return selection
    selection = on_the_same_world(rule, selection, field.revision, aim)
    if aim.has_line:
        return selection  # A line is followed even if the motion is slow.
    state = rule.law.robot.state(q)
    aimed = [i for i, _ in aim.items]
    speed = np.linalg.norm(state.arrays.Jv_WE[aimed] @ u, axis=1).max()
    fresh = not np.isfinite(selection.idle_until)
    if (
        fresh
        or speed >= STALL_SPEED
        or aim.is_reached(state.X_WEs, rule.arrived)
    ):
        return dc.replace(selection, idle_until=time + STALL_TIME)
    if time < selection.idle_until - 1e-9:
        return selection
    tiers = rule.candidates(q, aim, field)
    candidates = list(chain.from_iterable(tiers)) or [rule.start]
    known = selection.guidance in candidates
    i = candidates.index(selection.guidance) + 1 if known else 0
    following = candidates[i % len(candidates)]
    return dc.replace(
        selection,
        guidance=following,
        reason=f"{selection.guidance.name} stalled",
        # A standing robot needs time to accelerate.
        idle_until=time + 2 * STALL_TIME,
    )
