"""Guidance without look-ahead: when stuck, try the next candidate."""

import dataclasses as dc
from itertools import chain

import numpy as np

from remosplat_drake.controller.guidance.selection import (
    Selection,
    SelectionRule,
)

STALL_SPEED = 0.03
"""An end effector slower than this is stuck, if it has not arrived [m/s]."""

STALL_TIME = 0.2
"""For so long [s]."""


def cycle_when_stalled(
    rule: SelectionRule,
    selection: Selection,
    *,
    time: float,
    q: np.ndarray,
    u: np.ndarray,
) -> Selection:
    """Keeps the guidance while the end effector moves, else takes the next.

    Args:
        rule: Its candidates are cycled through, tier after tier.
        selection: Where it stands; `idle_until` is when patience ends.
        time: Present time [s].
        q: Measured configuration, shape (n_q,).
        u: Command being executed, shape (n_u,).
    """
    speed = np.linalg.norm(rule.law.robot.state(q).Jv_WE @ u)
    if speed >= STALL_SPEED or not np.isfinite(selection.idle_until):
        return dc.replace(selection, idle_until=time + STALL_TIME)
    if time < selection.idle_until - 1e-9:
        return selection
    candidates = list(chain.from_iterable(rule.candidates))
    i = candidates.index(selection.guidance)
    following = candidates[(i + 1) % len(candidates)]
    return dc.replace(
        selection,
        guidance=following,
        reason=f"{selection.guidance.name} stalled",
        idle_until=time + 2 * STALL_TIME,
    )
