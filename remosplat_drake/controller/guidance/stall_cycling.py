"""Selects guidance without rollouts: the next candidate if the robot stalls."""

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
"""An end effector that has not reached its target counts as stopped if its
speed is below this value [m/s]."""

STALL_TIME = 0.2
"""An end effector counts as stalled if it has been stopped for this time
[s]."""


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
    """Keeps the guidance while an end effector moves; else selects the next.

    Args:
        rule: The selector's settings; its candidates are selected in turn, tier
            after tier.
        selection: The selection so far. Its attribute `idle_until` is the time
            from which on the robot counts as stalled.
        time: Present time [s].
        q: Measured configuration, shape (n_q,) [rad, m].
        u: Command that is being executed, shape (n_u,).
        aim: The targets of the end effectors, as an `Aim`. A `Target` or a pose
            X_WT of shape (4, 4) is also accepted; it is the target of the first
            end effector.
        field: The map.
        movers: Not used.
        motion: Not used.
        payload: The payload; None if the robot carries nothing.
    """
    del movers, motion
    rule, aim = rule.holding(payload), Aim.of(aim)
    if not (np.isfinite(q).all() and aim.is_known):
        return selection
    selection = on_the_same_world(rule, selection, q, field, aim)
    rule = rule.from_tier(selection.tier)
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
        # A robot at rest needs time to accelerate.
        idle_until=time + 2 * STALL_TIME,
    )
