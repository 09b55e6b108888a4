"""`Stillness`: since when the robot stands still, or comes no nearer."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.pose_error import PoseError

STILL = 0.01
"""Change of a configuration variable that is no progress [m, rad]: a command
that trembles between two constraints gets nowhere either."""

_NEARER = 0.01
"""By how much a robot that comes nearer does so [m]."""


@dc.dataclass(frozen=True, eq=False)
class Stillness:
    """What is remembered of the robot's motion; copying returns itself.

    Attributes:
        q: Configuration that the robot has not left since, shape (n_q,).
        since: Time at which it came there, or last had a reason to rest [s].
        X_WT: Pose of the target that is meant, shape (4, 4).
        nearest: Least distance to that target so far [m].
        nearest_at: Time at which it was reached [s].
    """

    q: np.ndarray
    since: float
    X_WT: np.ndarray
    nearest: float
    nearest_at: float

    def __deepcopy__(self, memo) -> "Stillness":
        return self


def observe(
    before: Stillness | None,
    time: float,
    q: np.ndarray,
    X_WT: np.ndarray,
    error: PoseError,
    *,
    may_rest: bool,
) -> Stillness:
    """Looks at the robot once more.

    Args:
        before: What was remembered; None at the first look.
        time: Present time [s].
        q: Measured configuration, shape (n_q,).
        X_WT: Pose of the present target, shape (4, 4).
        error: The error from the end effector to it.
        may_rest: Whether the robot has every reason to stand still, at its
            target for example; that time does not count.
    """
    if before is None or time < before.since:
        return Stillness(q, time, X_WT, error.distance, time)
    now = before
    # What is not finite has not stayed where it was.
    if may_rest or not np.abs(q - before.q).max() <= STILL:
        now = dc.replace(now, q=q, since=time)
    is_new = not np.array_equal(X_WT, before.X_WT)
    if is_new or error.distance < before.nearest - _NEARER:
        now = dc.replace(
            now, X_WT=X_WT, nearest=error.distance, nearest_at=time
        )
    return now
