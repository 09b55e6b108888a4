"""Follow a planned path: a quadratic price on leaving it."""

import dataclasses as dc
import math
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.controller.planning.path import Path
from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick

_TURNING = 1e-9
"""Way of the base below which a stretch of the path only turns it [m]."""

_SHORTEST_PURSUIT = 0.2
"""Least distance at which a base steers for a place [m]: steering for a nearer
one would make it swing."""


@dc.dataclass
class PathTrackingConfig(Config):
    """How a planned path is followed."""

    # Weight of the squared deviation from the velocity along the path.
    weight: Annotated[float, Interval(gt=0, le=1000)] = 1.0
    # How far ahead on the path the robot aims, in radians and metres alike.
    look_ahead: Annotated[float, Interval(gt=0, le=2)] = 0.2
    # Proportional gain on what is left of the path, and on what is left to
    # where the base goes over from turning to driving [1/s].
    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0
    # Bound on the speed of all of the robot's spheres [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=2)] = 0.35


class PathTracking:
    """Makes the robot follow the path of the tick's guidance, if it has one.

    The cost is weight/2 |u - u_path|^2, where u_path leads to a point of the
    path a little ahead of the nearest one (pure pursuit; Coulter 1992). All
    rows of the program stay: what is in the way is kept off as ever.

    Args:
        config: Weight, speed and how far ahead the robot aims.
    """

    def __init__(self, config: PathTrackingConfig):
        self._config = config

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost of leaving the path.

        Args:
            program: The program of the tick.
            tick: What is known at the tick; the configuration and the
                guidance's path matter here.
        """
        path = tick.guidance.path
        if path is None:
            return
        u = path_velocity(path, tick, self._config)
        weights = np.full(program.n_u, self._config.weight)
        program.add_quadratic_cost("path", weights)
        program.add_linear_cost("path", -weights * u)


def path_velocity(
    path: Path, tick: Tick, config: PathTrackingConfig
) -> np.ndarray:
    """Computes the command that leads along a path, shape (n_u,).

    A base does not look beyond the corner at which it goes over from turning
    to driving or back, and slows down before it.

    Args:
        path: The path.
        tick: What is known at the tick; configuration and limits matter.
        config: Speed and how far ahead the robot aims.
    """
    robot, q = tick.robot, tick.state.q
    s, apart = path.nearest(q)
    goal, left = s + config.look_ahead, path.length - s + apart
    if robot.n_base:
        corner = _next_corner(path, s, 0.1 * config.look_ahead)
        goal = min(goal, corner)
        left = min(left, corner - s + 0.1 * config.look_ahead)
    e = path.at(goal) - q
    along = _unicycle(path, goal, q, e) if robot.n_base else e
    size = float(np.linalg.norm(along))
    if size < 1e-9:
        return np.zeros(robot.n_u)
    along = along / size
    fastest = np.linalg.norm(tick.state.Jv_WS @ along, axis=1).max(initial=0.0)
    limits = robot.velocity_limit / np.maximum(np.abs(along), 1e-9)
    speed = min(
        config.gain * left,
        config.max_speed / max(float(fastest), 1e-9),
        float(limits.min()),
    )
    return speed * along


def _drives(path: Path) -> np.ndarray:
    """Tells on which stretches of a path the base drives, shape (k,)."""
    return np.hypot(*np.diff(path.q[:, :2], axis=0).T) > _TURNING


def _next_corner(path: Path, s: float, reached: float) -> float:
    """Returns where the base next goes over from turning to driving or back.

    A corner that is nearer than `reached` lies behind.
    """
    drives = _drives(path)
    changes = path.s[1:-1][drives[1:] != drives[:-1]]
    ahead = changes[changes > s + reached]
    return float(ahead[0]) if len(ahead) else path.length


def _unicycle(
    path: Path, goal: float, q: np.ndarray, e: np.ndarray
) -> np.ndarray:
    """Maps a way through q to a base that cannot slip sideways, (n_u,).

    Args:
        path: The path.
        goal: Arc length at which the way ends.
        q: Where the robot is, shape (n_q,) [rad, m].
        e: The way there, shape (n_q,) [rad, m].
    """
    cosine, sine = math.cos(q[2]), math.sin(q[2])
    forward = cosine * e[0] + sine * e[1]
    aside = cosine * e[1] - sine * e[0]
    k = min(int(np.searchsorted(path.s, goal)), len(path.s) - 1) - 1
    turn = e[2]
    if k >= 0 and _drives(path)[k]:
        reach = max(math.hypot(e[0], e[1]), _SHORTEST_PURSUIT)
        turn = 2.0 * forward * aside / reach**2
    return np.concatenate([[forward, turn], e[3:]])
