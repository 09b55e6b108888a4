"""Computes the greatest speeds that limits and clearances permit along a path.

The speed at a point of the path is the greatest speed from which the robot can
keep, up to the path's end, its limits of velocity, acceleration and torque, and
the law of the collision damper. The speed depends only on the point, and not on
time. So a robot that is late or was pushed continues from its present place.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.ingredients import CollisionDamperConfig
from remosplat_drake.controller.ingredients.collision_damper import (
    approach_speed,
)
from remosplat_drake.controller.ingredients.path_tracking import CREEP
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.controllable_speeds import (
    controllable_speeds,
)
from remosplat_drake.controller.planning.kernels.damper_speeds import (
    damper_speeds,
)
from remosplat_drake.controller.planning.steering import segment_commands
from remosplat_drake.controller.program.path import Path
from remosplat_drake.robot.robot_model import RobotModel

_STEP = 0.06
"""Speeds are computed at points of a path that are at most this distance apart.
In this distance, a radian counts like a metre."""

_SHARE = 0.9
"""Fraction of the limits of acceleration and torque that a path uses. The rest
is available for corrections."""

_SHARP = 0.3
"""If the direction changes at a node by more than this angle, the node is a
corner, and not a part of a bend [rad]."""


@dc.dataclass(frozen=True)
class TimingLimits:
    """Bounds of speeds along paths, in addition to the robot's limits.

    Attributes:
        damper: Settings of the collision damper.
        approach_scale: Factor of the damper's gain on paths.
        dt: The control period [s].
    """

    damper: CollisionDamperConfig = dc.field(
        default_factory=CollisionDamperConfig
    )
    approach_scale: float = 1.0
    dt: float = 0.02


def timed_path(
    space: FreeSpace, corners: np.ndarray, limits: TimingLimits
) -> Path:
    """Finds the greatest speeds along a path.

    Args:
        space: The free space.
        corners: Corners of a free path, shape (k, n_q) [rad, m].
        limits: Bounds of speeds in addition to the robot's limits.

    Returns:
        The path through the corners and through points between them, with
        speeds. If there is only one corner, the path has no speeds.
    """
    robot, path = space.robot, Path.through(_refined(corners))
    if len(path.q) < 2:
        return path
    step = np.diff(path.s)
    rate = segment_commands(path.q, robot.n_base) / step[:, None]
    turn, bend, is_sharp = _turns(rate, step)
    fastest = _fastest(rate, robot.velocity_limit)
    fastest[1:] = np.minimum(fastest[1:], fastest[:-1])
    slope = approach_speed(
        limits.damper, limits.approach_scale, space.stopping, 1.0
    )
    law = slope, space.stopping, CREEP
    with space.calls() as line:
        fastest = damper_speeds(
            space.arrays, line, (path.q, path.s), fastest, law
        )
    # At a sharp corner, the command changes instantly. The change must be at
    # most that which is permitted in one control period.
    acceleration = _SHARE * robot.acceleration_limit
    through = _fastest(turn, acceleration * limits.dt)
    fastest[is_sharp] = np.minimum(fastest, through)[is_sharp]
    own, torque = (rate, bend, np.zeros_like(rate)), _torques(robot, path)
    v, a = controllable_speeds(
        *(np.hstack(pair) for pair in zip(own, torque[:3], strict=True)),
        np.concatenate([acceleration, torque[3]]),
        step,
        fastest,
    )
    return Path(path.q, path.s, v, a)


def _refined(corners: np.ndarray) -> np.ndarray:
    """Adds points on segments that are longer than a step."""
    way = np.diff(corners, axis=0)
    pieces = np.ceil(np.linalg.norm(way, axis=1) / _STEP).astype(int)
    pieces = np.maximum(pieces, 1)
    segment = np.repeat(np.arange(len(pieces)), pieces)
    before = np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = (np.arange(1, len(segment) + 1) - before) / pieces[segment]
    points = corners[:-1][segment] + share[:, None] * way[segment]
    return np.concatenate([corners[:1], points])


def _fastest(rate: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Returns the greatest v with |rate| v <= limit, shape (k,) [1/s]."""
    return (limit / np.maximum(np.abs(rate), 1e-9)).min(axis=1)


def _turns(
    rate: np.ndarray, step: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns the changes of a rate at the nodes, in total and per arc length.

    Returns:
        Both changes, each of shape (k, m), and whether the change at each node
        is sharp, shape (k,). If a change is sharp, its change per arc length is
        set to zero.
    """
    turn = np.diff(rate, axis=0, prepend=rate[:1])
    is_sharp = np.linalg.norm(turn, axis=1) > _SHARP
    around = 0.5 * (step + np.concatenate([step[:1], step[:-1]]))
    bend = np.where(is_sharp[:, None], 0.0, turn / around[:, None])
    return turn, bend, is_sharp


def _torques(
    robot: RobotModel, path: Path
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Returns torques on a path: per dv/dt, per v^2, at rest, and bounds.

    The torque bound of a motor is at least the torque that the motor needs at
    rest.
    """
    step = np.diff(path.s)
    rate = np.diff(path.q, axis=0) / step[:, None]
    (_, bend, _), zero = _turns(rate, step), np.zeros_like(rate)
    v, a = np.stack([zero, zero, rate], 1), np.stack([zero, rate, bend], 1)
    torque = robot.dynamics.torques(path.q[:-1], v, a)
    at_rest = torque[:, 0]
    pushing, turning = torque[:, 1] - at_rest, torque[:, 2] - at_rest
    most = np.abs(at_rest).max(axis=0)
    limit = np.maximum(_SHARE * robot.dynamics.limit, most)
    return pushing, turning, at_rest, limit
