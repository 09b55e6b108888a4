"""Finds standing movers, which paths avoid until the movers have left.

Paths do not avoid movers that are in motion. These will have left when the
robot arrives; otherwise the robot waits.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.guidance.present_state import PresentState
from remosplat_drake.scene.mover import Mover, Movers

SLOW = 0.1
"""A mover counts as standing if its speed is below this value [m/s]."""

_GONE = 0.2
"""A mover counts as having left if it has moved farther than this [m]."""

NOTHING = Movers(0.0)
"""The value if there are no standing movers."""


def standing(now: PresentState) -> Movers:
    """Finds the standing movers and their present poses.

    Args:
        now: The present state.

    Returns:
        The standing movers with zero twists, stamped with the present time.
    """
    if now.movers is None:
        return NOTHING
    age, none = abs(now.time - now.movers.stamp), np.zeros(3)
    return Movers(
        now.time,
        [
            dc.replace(m, X_WM=m.after(age), v_WM=none, w_WM=none)
            for m in now.movers
            if m.speed < SLOW
        ],
    )


def gone_mover(before: Movers, now: PresentState) -> str:
    """Returns the name of a standing mover that has left; empty if none has.

    Args:
        before: The standing movers at an earlier time, which `standing`
            returned.
        now: The present state.
    """
    if not len(before):
        return ""
    present = tuple(now.movers or ())
    gone = (m.name for m in before if not any(_is_at(p, m) for p in present))
    return next(gone, "")


def _is_at(mover: Mover, before: Mover) -> bool:
    """Whether two movers are the same mover at the same place."""
    moved = mover.X_WM.translation() - before.X_WM.translation()
    is_near = bool(np.linalg.norm(moved) <= _GONE)
    return mover.name == before.name and is_near
