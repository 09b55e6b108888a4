"""Finds statuses that no arm can have: of another robot, or of an error."""

import numpy as np

from remosplat_drake.hardware.wire.panda import PandaState

_SLACK = 0.02
"""By how much a joint may seem to move beyond its speed limit, since stamps
and arrivals are not quite the measurements' times [rad]."""

_FASTER = 1.2
"""How much faster than its limit a joint may be said to turn: limits keep
commands, and measurements have noise."""


def arm_jump(
    before: PandaState, after: PandaState, duration: float, limit: np.ndarray
) -> str:
    """Names a joint with an impossible motion; empty if there is none.

    Args:
        before: The state before.
        after: The state after it.
        duration: Time between the two, at least [s].
        limit: Bounds on |v|, shape (n,) or (1,) [rad/s].
    """
    limit = np.broadcast_to(limit, after.q.shape)
    fast = np.abs(after.v) > _FASTER * limit + _SLACK
    if fast.any():
        i = int(fast.argmax())
        return (
            f"joint {i + 1} is said to turn at {abs(after.v[i]):.2f} rad/s,"
            f" and can do {limit[i]:.2f}"
        )
    moved = np.abs(after.q - before.q)
    excess = moved - (limit * max(duration, 0.0) + _SLACK)
    if excess.max() > 0:
        i = int(excess.argmax())
        return (
            f"joint {i + 1} jumped by {moved[i]:.3f} rad in"
            f" {1e3 * max(duration, 0.0):.0f} ms"
        )
    return ""
