"""`Stillness`: duration of the robot's standstill or lack of progress."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

STILL = 0.01
"""Change of a configuration variable that does not count as motion [m, rad]: a
command may oscillate between two constraints."""

PAUSE = 1.0
"""Time of standstill after which the robot counts as held [s]. A robot that
takes longer than this to move by `STILL` also counts as held."""

_NEARER = 0.01
"""Least decrease of the distance that counts as progress [m]."""


_ARM = 0.3
"""Length that weights an angle if a target has no position [m]."""


@dc.dataclass(frozen=True, eq=False)
class Stillness:
    """Memory of the robot's motion; copying returns the object itself.

    Attributes:
        q: Configuration from which the robot has not moved by `STILL`, shape
            (n_q,) [m, rad].
        there_since: Time at which it arrived at `q` [s].
        since: Start of the present standstill [s]. Since then, the robot has at
            most crept, and had no reason to rest.
        aim: The current aim.
        nearest: Least distance to the aim so far, summed over end effectors
            [m]. For a target of orientation only, it is the angle times a
            length.
        nearest_at: Time at which `nearest` was reached [s].
    """

    q: np.ndarray
    there_since: float
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
    """Updates the memory.

    Args:
        before: The previous memory; None at first.
        time: Present time [s].
        q: Measured configuration, shape (n_q,).
        aim: The current aim.
        X_WEs: Poses of the end effectors, shape (e, 4, 4).
        may_rest: Whether the robot has a reason to stand still, at its target
            for example. Such time does not count as standstill.
    """
    left = sum(_left(t, t.error(X_WEs[i])) for i, t in aim.items)
    if before is None or time < before.since:
        return Stillness(q, time, time, aim, left, time)
    now = before
    # A configuration that is not finite counts as motion.
    change = np.abs(q - before.q).max()
    if may_rest or not change <= STILL:
        is_slow = change <= 2.0 * STILL and time - before.there_since >= PAUSE
        since = before.since if is_slow and not may_rest else time
        now = dc.replace(now, q=q, there_since=time, since=since)
    is_new = not aim.equals(before.aim)
    if is_new or left < before.nearest - _NEARER:
        now = dc.replace(now, aim=aim, nearest=left, nearest_at=time)
    return now


def _left(target: Target, error: PoseError) -> float:
    return error.distance if target.asks_for_place else _ARM * error.angle
