"""Commands that show how an axis follows: a crawl, and full-speed stops."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField

CRAWLS = (0.01, 0.03)
"""Slow speeds, as shares of an axis' limit, that find its dead band."""

PAUSE = 1.5
"""Time to come to rest between two motions [s]."""

_HOLD = 0.1
"""Time at the full speed before the stop [s]."""

_CRAWL = 0.6
"""Time of a crawl [s]."""

_OVERRUN = 0.4
"""By how much of its speed an axis may be late for a stop [s]."""

_SPEEDS = (1.0, 0.5, 0.25, 0.125)
"""Shares of the limit that are tried for the full-speed stop."""

_LOOKS = 13


@dc.dataclass(frozen=True)
class Stroke:
    """The room that one axis has for its motions.

    Attributes:
        axis: Index of the axis in u.
        speed: Greatest speed, positive forth and negative back first
            [m/s, rad/s].
    """

    axis: int
    speed: float


def find_stroke(
    robot: RobotModel,
    field: DistanceField,
    q: np.ndarray,
    axis: int,
    limit: np.ndarray,
    clearance: float,
) -> Stroke | None:
    """Finds the fastest motion of one axis that stays away from everything.

    Args:
        robot: The robot.
        field: The map.
        q: Configuration to start from, shape (n_q,) [m, rad].
        axis: Index of the axis in u.
        limit: Bounds on |u|, shape (n_u,) [m/s, rad/s].
        clearance: Distance that all spheres keep from the scene [m].

    Returns:
        The stroke; None where there is no room even for a slow one.
    """
    for share in _SPEEDS:
        for sign in (1.0, -1.0):
            speed = sign * share * limit[axis]
            if _is_free(robot, field, q, axis, speed, clearance):
                return Stroke(axis, speed)
    return None


def _is_free(
    robot: RobotModel,
    field: DistanceField,
    q: np.ndarray,
    axis: int,
    speed: float,
    clearance: float,
) -> bool:
    ramp = speed**2 / robot.acceleration_limit[axis]
    way = math.copysign(ramp + abs(speed) * (_HOLD + _OVERRUN), speed)
    back = -speed * _OVERRUN
    u = np.zeros(robot.n_u)
    u[axis] = 1.0
    times = np.linspace(back, way, _LOOKS)
    for q_then in robot.advance_for(q, u, times):
        inside = (q_then >= robot.position_lower) & (
            q_then <= robot.position_upper
        )
        spheres = robot.spheres_at(q_then)
        far = field.clearances(spheres, 2 * clearance).minimum()
        if not (inside.all() and far >= clearance):
            return False
    return True


def commands(
    stroke: Stroke, robot: RobotModel, limit: np.ndarray, dt: float
) -> np.ndarray:
    """Makes the commands of one axis, shape (k, n_u) [m/s, rad/s].

    It crawls forth and back, and then goes as fast as it may, stops by the
    braking ramp, and comes back the same way. All changes are within the
    acceleration limits.

    Args:
        stroke: The axis and its speed.
        robot: The robot, for its acceleration limits.
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
