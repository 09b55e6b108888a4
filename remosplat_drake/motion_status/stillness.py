"""`Stillness`: the duration of a standstill, or of a lack of progress."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.pose_error import PoseError, pose_error
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

STILL = 0.01
"""A change of a configuration variable by at most this value does not count as
motion [m, rad], since a command may oscillate between two constraints."""

PAUSE = 0.6
"""Time of standstill after which the sentence states a cause [s]. A robot that
takes longer than this time to move by `STILL` counts as being at rest, too."""

_NEARER = 0.01
"""A decrease of the distance counts as progress if it is at least this value
[m]."""


_ARM = 0.3
"""For targets that constrain only the orientation, the distance to the target
is the angle times this length [m]."""


@dc.dataclass(frozen=True, eq=False)
class Rest:
    """The time for which a value has been at rest.

    Attributes:
        at: Stored value, an array of any shape. The value is at rest as long as
            it differs from the stored value by at most `STILL`.
        there_since: Time at which the value was stored [s]. It is stored again
            after each larger change, and at all times at which the robot may
            rest.
        since: Start of the present standstill [s]. It may be before
            `there_since`, since slow changes do not end a standstill. The time
            in which the robot may rest, for example at its target, is not part
            of a standstill.
    """

    at: np.ndarray
    there_since: float
    since: float

    def updated(
        self, time: float, at: np.ndarray, change: float, may_rest: bool
    ) -> "Rest":
        """Returns the object after a measurement.

        Args:
            time: Present time [s].
            at: Present value.
            change: Difference of the present value from the stored value. A
                difference that is not finite counts as motion.
            may_rest: Whether the robot has a reason to rest.
        """
        if change <= STILL and not may_rest:
            return self
        is_slow = change <= 2.0 * STILL and time - self.there_since >= PAUSE
        since = self.since if is_slow and not may_rest else time
        return Rest(at, time, since)


@dc.dataclass(frozen=True, eq=False)
class Stillness:
    """The robot's past motion; copying returns the object itself.

    Attributes:
        robot: The `Rest` of the configuration, shape (n_q,) [m, rad].
        hands: The `Rest` of the poses of the end effectors, shape (e, 4, 4).
            End effectors may be at rest while the base or an elbow moves.
        aim: The current aim.
        nearest: Smallest distance to the targets so far, as a sum over the end
            effectors [m]. For a target that constrains only the orientation,
            the distance is the angle times a length.
        nearest_at: Time at which `nearest` was reached [s].
    """

    robot: Rest
    hands: Rest
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
    """Updates a robot's past motion by a measurement.

    Args:
        before: The past motion before the measurement; None at the start.
        time: Present time [s].
        q: Measured configuration, shape (n_q,).
        aim: The current aim.
        X_WEs: Poses of the end effectors, shape (e, 4, 4).
        may_rest: Whether the robot has a reason to rest, for example because it
            is at its target. Such a rest does not count as standstill.
    """
    left = sum(_left(t, t.error(X_WEs[i])) for i, t in aim.items)
    if before is None or time < before.robot.since:
        robot, hands = Rest(q, time, time), Rest(X_WEs, time, time)
        return Stillness(robot, hands, aim, left, time)
    moved = float(np.abs(q - before.robot.at).max())
    hand_moved = _moved(before.hands.at, X_WEs, aim)
    now = dc.replace(
        before,
        robot=before.robot.updated(time, q, moved, may_rest),
        hands=before.hands.updated(time, X_WEs, hand_moved, may_rest),
    )
    is_new = not aim.equals(before.aim)
    if is_new or left < before.nearest - _NEARER:
        now = dc.replace(now, aim=aim, nearest=left, nearest_at=time)
    return now


def _moved(before: np.ndarray, X_WEs: np.ndarray, aim: Aim) -> float:
    """Returns the largest motion of end effectors with a target [m]."""
    return max(
        error.distance + _ARM * error.angle
        for i, _ in aim.items
        for error in [pose_error(before[i], X_WEs[i])]
    )


def _left(target: Target, error: PoseError) -> float:
    return error.distance if target.constrains_position else _ARM * error.angle
