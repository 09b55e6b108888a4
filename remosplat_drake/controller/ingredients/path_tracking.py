"""Path tracking: a quadratic cost of deviations from a planned path."""

import dataclasses as dc
import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import NOTHING
from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.kernels.path_places import (
    nearest_place,
    place_at,
)
from remosplat_drake.controller.program.kernels.path_speeds import (
    change_at,
    way_ahead,
)
from remosplat_drake.robot.robot_model import RobotModel

_TURNING = 1e-9
"""Distance between two points of a path below which a differential base turns
on the spot from one to the other, and does not drive [m]."""

_SHORTEST_PURSUIT = 0.2
"""Least distance of the point towards which a base steers [m]. If it steered
towards nearer points, the heading would oscillate."""

_NEAR = 0.02
"""Distance from a point of the path with zero speed below which the robot's
speed is proportional to the distance, so that the robot does not stop before
this point. A radian counts like a metre."""

CREEP = 0.3
"""Least speed along a path that the cost tracks [1/s]; a radian counts like a
metre. If rows of the program allow only a lower speed, they change the
direction of the command, so that the robot slides past a near obstacle."""


@dc.dataclass
class PathTrackingConfig(Config):
    """Settings of the tracking of planned paths."""

    # Weight of the squared deviation from the velocity along the path.
    weight: Annotated[float, Interval(gt=0, le=1000)] = 1.0
    # Least look-ahead distance along the path; a radian counts like a metre.
    look_ahead: Annotated[float, Interval(gt=0, le=2)] = 0.05
    # Proportional gain of the remaining length of a path without speeds [1/s].
    # For a path with speeds, it is used near points at which the path's speed
    # is zero.
    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Bound of the speed of all spheres of the robot [m/s]. If it is absent,
    # there is no bound, or 0.35 m/s on a real robot.
    max_speed: Annotated[float, Interval(gt=0, le=10)] | None = None


class PathTracking(CompiledIngredient):
    """A cost that makes the robot follow the path of guidance, if there is one.

    `add_path_tracking` computes its cost.

    Args:
        config: Settings such as weight, speed and look-ahead distance.
    """

    term = "path"

    def __init__(self, config: PathTrackingConfig):
        self._config = config

    def settings(self, robot: RobotModel) -> "PathTrackingSettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        config = self._config
        return PathTrackingSettings(
            config.weight,
            config.look_ahead,
            config.gain,
            math.inf if config.max_speed is None else config.max_speed,
        )


class PathTrackingSettings(NamedTuple):
    """Settings of a `PathTracking` for kernels."""

    weight: float
    look_ahead: float
    gain: float
    max_speed: float


@kernel(returns=NOTHING)
def add_path_tracking(own, k, tick, program):
    """Adds a cost of deviations from the path of guidance.

    The cost is, up to a constant,

        weight/2 |u - u_path|^2,

    where u_path leads to a point of the path slightly ahead of the point
    nearest to the robot (pure pursuit; Coulter 1992); see `_path_velocity`. The
    constraints of the program hold, too. If there is no path, there is no cost.

    See `CompiledIngredient` for the arguments.
    """
    if len(tick.guidance.path_s) == 0:
        return
    program.has[k, 0] = program.has[k, 1] = True
    u = _path_velocity(own, tick, program)
    for j in range(len(u)):
        program.quadratic[k, j] = own.weight
        program.linear[k, j] = -own.weight * u[j]


@helper
def _path_velocity(own, tick, program):
    """Computes the command that leads along the path, shape (n_u,).

    The command leads from q to the point of the path at the distance
    `look_ahead` after the nearest point, or farther if the robot moves farther
    in a tick. Its speed is the path's speed at the nearest point and does not
    depend on time. So a robot that is late or was pushed continues from its
    present place. If the path has no speeds, the speed is `gain` times the
    remaining length.

    For a differential base, the look-ahead ends at corners between turning and
    driving, where the path's speed is zero.
    """
    robot, q = tick.robot, tick.state.q
    path_q, path_s = tick.guidance.path_q, tick.guidance.path_s
    path_v = tick.guidance.path_v
    s, apart = nearest_place(path_q, path_s, q)
    left = path_s[-1] - s + apart
    corner = path_s[-1]
    if robot.n_base == 2:
        corner = _corner_after(path_q, path_s, s + _NEAR)
        left = min(left, corner - s + _NEAR)
    way, speed = 0.0, own.gain * left
    if len(path_v):
        way = way_ahead(path_s, path_v, s, tick.dt)
        speed = max(way / tick.dt, own.gain * min(left, _NEAR))
    goal = min(s + max(own.look_ahead, way), corner)
    along = place_at(path_q, path_s, goal)
    for j in range(len(q)):
        along[j] -= q[j]
    if robot.n_base == 2:
        along = _without_slip(path_q, path_s, goal, q, along)
    elif robot.n_base:
        x, y, yaw = along[0], along[1], q[2]
        along[0] = math.cos(yaw) * x + math.sin(yaw) * y
        along[1] = math.cos(yaw) * y - math.sin(yaw) * x
    square = 0.0
    for j in range(len(along)):
        square += along[j] * along[j]
    if square < 1e-18:
        return np.zeros(len(tick.u_previous))
    for j in range(len(along)):
        along[j] /= math.sqrt(square)
    if own.max_speed < math.inf:
        fastest = max(_fastest(robot, tick.state, along), 1e-9)
        speed = min(speed, own.max_speed / fastest)
    if len(path_v):
        now = 0.0
        for j in range(len(along)):
            now += along[j] * tick.u_previous[j]
        now = max(now, 0.0)
        a = change_at(path_s, path_v, tick.guidance.path_a, s, now)
        speed = min(speed, now + a * tick.dt)
    speed = _speed_within(program, along, speed)
    for j in range(len(along)):
        along[j] *= speed
    return along


@helper
def _speed_within(program, along, speed):
    """Returns the largest feasible speed along a direction, at most `speed`.

    Rows and bounds scale the whole command, so that the robot stays on the
    path. The bounds of an axis that still moves in the opposite direction are
    ignored, since this axis must reverse first.

    Args:
        program: The `ProgramArrays`, with rows and bounds.
        along: The direction, shape (n_u,).
        speed: The desired speed.
    """
    for i in range(program.count[0]):
        rate = 0.0
        for j in range(len(along)):
            rate += program.A[i, j] * along[j]
        if rate > 1e-9:
            speed = min(speed, max(program.b[i] / rate, CREEP))
    least, most = 0.0, math.inf
    for j in range(len(along)):
        slow, fast = program.lower[j], program.upper[j]
        if along[j] < 0.0:
            slow, fast = -fast, -slow
        size = abs(along[j])
        if size > 1e-9 and fast > 0.0:
            least, most = max(least, slow / size), min(most, fast / size)
    return min(max(speed, least), most)


@helper
def _fastest(robot, state, u):
    """Returns the speed of the fastest sphere for a command [m/s]."""
    square = 0.0
    for i in range(len(robot.body_S)):
        x, y, z = 0.0, 0.0, 0.0
        for j in range(len(u)):
            if not robot.moves[robot.body_S[i], j]:
                continue
            a = state.a_W[j]
            if not robot.screw_turns[j]:
                x, y, z = x + u[j] * a[0], y + u[j] * a[1], z + u[j] * a[2]
                continue
            r = state.p_WS[i] - state.o_W[j]
            x += u[j] * (a[1] * r[2] - a[2] * r[1])
            y += u[j] * (a[2] * r[0] - a[0] * r[2])
            z += u[j] * (a[0] * r[1] - a[1] * r[0])
        square = max(square, x * x + y * y + z * z)
    return math.sqrt(square)


@helper
def _drives_on(path_q, k):
    """Whether the base drives on stretch k of a path."""
    x, y = path_q[k + 1, 0] - path_q[k, 0], path_q[k + 1, 1] - path_q[k, 1]
    return math.hypot(x, y) > _TURNING


@helper
def _corner_after(path_q, path_s, s):
    """Returns the next corner after s between turning and driving.

    Returns:
        The arc length of this corner, or that of the path's end if there is
        none.
    """
    for k in range(1, len(path_s) - 1):
        turns = _drives_on(path_q, k) != _drives_on(path_q, k - 1)
        if turns and path_s[k] > s:
            return path_s[k]
    return path_s[-1]


@helper
def _without_slip(path_q, path_s, goal, q, e):
    """Maps a displacement e of q to a command without sideways slip, (n_u,).

    On a stretch on which the base drives, the command follows the circle that
    is tangent to the base's heading and passes through the goal (pure pursuit).
    On a stretch on which the base turns, it turns by the angle in e.
    """
    cosine, sine = math.cos(q[2]), math.sin(q[2])
    forward = cosine * e[0] + sine * e[1]
    aside = cosine * e[1] - sine * e[0]
    k = 0
    while k < len(path_s) and path_s[k] < goal:
        k += 1
    k = min(k, len(path_s) - 1) - 1
    turn = e[2]
    if k >= 0 and _drives_on(path_q, k):
        reach = max(math.hypot(e[0], e[1]), _SHORTEST_PURSUIT)
        turn = 2.0 * forward * aside / reach**2
    along = np.empty(len(e) - 1)
    along[0], along[1] = forward, turn
    for j in range(2, len(along)):
        along[j] = e[j + 1]
    return along
