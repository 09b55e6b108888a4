"""Makes commands that identify an axis: slow motions, and fast stops."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.app.identification.room import NoRoomError, Room
from remosplat_drake.controller.verification.kernels.places import held
from remosplat_drake.controller.verification.verify import Surroundings
from remosplat_drake.robot.robot_model import RobotModel

CRAWLS = (0.01, 0.03)
"""Slow speeds that reveal an axis' dead band, as fractions of its speed
limit."""

PAUSE = 1.5
"""Pause between two motions, in which the axis comes to rest [s]."""

_HOLD = 0.1
"""Time for which the axis moves at constant full speed before it stops [s]."""

_CRAWL = 0.6
"""Duration of each slow motion [s]."""

_OVERRUN = 0.4
"""An axis is assumed to move for at most this time after it should have stopped
[s]."""

_SPEEDS = (1.0, 0.5, 0.25, 0.125)
"""Speeds of the motion that ends with a fast stop, as fractions of the speed
limit. They are tried in this order."""

TOO_FAST = "verification reduced the speed of faster motions"
"""Part of an error's text: the reason why faster motions are not tried."""

_LOOKS = 12
"""If the map is not Lipschitz, each direction of a motion is checked at this
number of configurations."""


@dc.dataclass(frozen=True)
class Stroke:
    """A motion of one axis, forth and back.

    Attributes:
        axis: Index of the axis in u.
        speed: Greatest speed [m/s, rad/s]. If it is positive, the axis moves
            forwards first; if it is negative, backwards first.
    """

    axis: int
    speed: float

    def ends(self, acceleration_limit: np.ndarray) -> tuple[float, float]:
        """Returns the largest excursions of the axis from its start.

        They include the distance that the axis travels if it stops late and
        keeps its speed until then.

        Args:
            acceleration_limit: Bounds on |du/dt|, shape (n_u,).

        Returns:
            The distance in the direction of motion, including ramps, and the
            distance to the other side [m, rad].
        """
        ramps = abs(self.speed) / acceleration_limit[self.axis]
        return self.speed * (ramps + _HOLD + _OVERRUN), -self.speed * _OVERRUN


def find_stroke(
    room: Room,
    q: np.ndarray,
    axis: int,
    limit: np.ndarray,
    fastest: float = 1.0,
) -> Stroke:
    """Finds the fastest motion of an axis that keeps the required distances.

    Args:
        room: The scene, and the distances that the robot must keep.
        q: Configuration in the map to start from, shape (n_q,) [m, rad].
        axis: Index of the axis in u.
        limit: Bounds on |u|, shape (n_u,) [m/s, rad/s].
        fastest: Only speeds up to this fraction of the bound are tried.

    Returns:
        The stroke.

    Raises:
        NoRoomError: The start, or all motions, are too near to an obstacle; the
            text names the obstacle.
    """
    problem = room.problem(q)
    if problem:
        raise NoRoomError(problem)
    around = room.surroundings(q)
    objections = [] if fastest >= 1.0 else [TOO_FAST]
    for share in (share for share in _SPEEDS if share <= fastest):
        for sign in (1.0, -1.0):
            stroke = Stroke(axis, sign * share * limit[axis])
            found = _objection(stroke, around)
            if not found:
                return stroke
            objections.append(found)
    raise NoRoomError(", ".join(dict.fromkeys(objections)))


def _objection(stroke: Stroke, around: Surroundings) -> str:
    """Returns an obstacle of a motion or of its late stop; "" if none."""
    robot, q = around.robot, around.state.q
    for end in stroke.ends(robot.acceleration_limit):
        u = np.zeros(robot.n_u)
        u[stroke.axis] = math.copysign(1.0, end)
        times = np.linspace(0.0, abs(end), _LOOKS + 1)[1:]
        found = around.objection(held(q, u, robot.n_base, times, times))
        if found:
            return found
    return ""


def commands(
    stroke: Stroke, robot: RobotModel, limit: np.ndarray, dt: float
) -> np.ndarray:
    """Makes the commands that identify one axis, shape (k, n_u) [m/s, rad/s].

    The axis moves slowly forwards and backwards. Then it moves at full speed,
    stops along the braking ramp, and returns in the same way. All commands are
    within the acceleration limits.

    Args:
        stroke: The axis and its speed.
        robot: The robot, which has the acceleration limits.
        limit: Bounds on |u|, shape (n_u,) [m/s, rad/s].
        dt: Control period [s].
    """
    step = robot.acceleration_limit[stroke.axis] * dt
    sign = math.copysign(1.0, stroke.speed)
    crawls = [sign * share * limit[stroke.axis] for share in CRAWLS]
    motions = [(speed, _CRAWL) for speed in crawls] + [(stroke.speed, _HOLD)]
    rest = [0.0] * round(PAUSE / dt)
    line = list(rest)
    for speed, hold in motions:
        for direction in (1.0, -1.0):
            line += _trapezoid(direction * speed, hold, step, dt) + rest
    u = np.zeros((len(line), robot.n_u))
    u[:, stroke.axis] = line
    return u


def _trapezoid(speed: float, hold: float, step: float, dt: float) -> list:
    n = max(math.ceil(abs(speed) / step), 1)
    up = [speed * (k + 1) / n for k in range(n)]
    return up + [speed] * round(hold / dt) + up[-2::-1] + [0.0]
