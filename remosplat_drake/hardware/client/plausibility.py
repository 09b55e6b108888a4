"""Detects statuses of an arm that no motion explains."""

import numpy as np

from remosplat_drake.hardware.wire.panda import PandaState

_SLACK = 0.02
"""A joint may move farther than at its speed limit by this angle [rad], because
stamps and times of arrival differ slightly from the times of measurement.
"""

_FASTER = 1.2
"""A measured rate may exceed the joint's limit by this factor, because limits
apply to commands, and measurements have noise."""


def arm_jump(
    before: PandaState, after: PandaState, duration: float, limit: np.ndarray
) -> str:
    """Describes an impossible motion of a joint; empty if there is none.

    Args:
        before: An earlier state of the arm.
        after: The next state of the arm.
        duration: Time between the two states [s].
        limit: Bounds on |v|, shape (n,) or (1,) [rad/s].
    """
    limit = np.broadcast_to(limit, after.q.shape)
    fast = np.abs(after.v) > _FASTER * limit + _SLACK
    if fast.any():
        i = int(fast.argmax())
        return (
            f"joint {i + 1} reports {abs(after.v[i]):.2f} rad/s, beyond its"
            f" limit {limit[i]:.2f} rad/s"
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
