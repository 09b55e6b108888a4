"""`Stillness`: since when the robot stands still, or comes no nearer."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

STILL = 0.01
"""Change of a configuration variable that is no progress [m, rad]: a command
that trembles between two constraints gets nowhere either."""

_NEARER = 0.01
"""By how much a robot that comes nearer does so [m]."""


_ARM = 0.3
"""Length by which an angle is weighed where no place is asked for [m]."""


@dc.dataclass(frozen=True, eq=False)
class Stillness:
    """What is remembered of the robot's motion; copying returns itself.

    Attributes:
        q: Configuration that the robot has not left since, shape (n_q,).
        since: Time at which it came there, or last had a reason to rest [s].
        aim: What is asked for.
        nearest: Least distance to that so far, summed over end effectors; of a
            target that only asks to turn, the angle as long as an arm [m].
        nearest_at: Time at which it was reached [s].
    """

    q: np.ndarray
    since: float
    aim: Aim
    nearest: float
    nearest_at: float

    def __deepcopy__(self, memo) -> "Stillness":
        return self


def observe(
    before: Stillness | None,
    time: float,
    q: np.ndarray,
    aim: Aim,
    X_WEs: np.ndarray,
    *,
    may_rest: bool,
) -> Stillness:
    """Looks at the robot once more.

    Args:
        before: What was remembered; None at the first look.
        time: Present time [s].
        q: Measured configuration, shape (n_q,).
        aim: What is asked for at present.
        X_WEs: Poses of the end effectors, shape (e, 4, 4).
        may_rest: Whether the robot has every reason to stand still, at its
            target for example; that time does not count.
    """
    left = sum(_left(t, t.error(X_WEs[i])) for i, t in aim.items)
    if before is None or time < before.since:
        return Stillness(q, time, aim, left, time)
    now = before
    # What is not finite has not stayed where it was.
    if may_rest or not np.abs(q - before.q).max() <= STILL:
        now = dc.replace(now, q=q, since=time)
    is_new = not aim.equals(before.aim)
    if is_new or left < before.nearest - _NEARER:
        now = dc.replace(now, aim=aim, nearest=left, nearest_at=time)
    return now


def _left(target: Target, error: PoseError) -> float:
    return error.distance if target.asks_for_place else _ARM * error.angle
