"""Generates random shelves, boxes and tables beside any robot.

Sizes are proportional to the robot's reach, so that each kind is equally narrow
for small and for large arms.
"""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.reach import arm_reach, shoulder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

_BOARD = 0.02
"""Thickness of all boards [m]."""

_LEG = 0.04
"""Thickness of a table's legs [m]."""

_ROOM = 0.2
"""Furniture is at least this far from the robot in its home configuration [m].
"""

_TRIES = 2000
"""For a piece of furniture, this many random places are tried."""


@dc.dataclass(frozen=True, eq=False)
class Furniture:
    """A piece of furniture, and the space inside it for the hand.

    Attributes:
        scene: The boards.
        inside: Boxes, one of which contains the hand's position at a goal.
    """

    scene: PrimitiveScene
    inside: tuple[Box, ...]

    def holds(self, p_WE: np.ndarray) -> bool:
        """Returns whether a point is in the space for the hand.

        Args:
            p_WE: The point in W, shape (3,) [m].
        """
        for box in self.inside:
            p_PE = box.X_WP.inverse().multiply(p_WE)
            if (np.abs(p_PE) < box.half_extents).all():
                return True
        return False


def furniture(robot: RobotModel, kind: str, seed: int) -> Furniture:
    """Generates a piece of furniture beside a robot that stands at the origin.

    - `shelf`: two to four bays one above the other, with a back and sides. A
      bay is 0.5 to 0.9 m wide, 0.3 to 0.45 m deep and 0.28 to 0.42 m high.
    - `box`: open at its top, 0.4 to 0.6 m long and wide and 0.2 to 0.35 m deep.
    - `under_table`: a table on four legs, 0.8 to 1.4 m wide, 0.5 to 0.8 m deep
      and 0.55 to 0.75 m high; hands reach under it.

    The distance from the shoulder is 0.35 to 0.75 of the arm's reach. The
    bottom of a shelf or a box is below the shoulder.

    Args:
        robot: The robot.
        kind: One of `KINDS`.
        seed: Any non-negative integer; with the robot's name and the kind, it
            determines the result.

    Raises:
        RemoSplatError: No place beside the robot is free.
    """
    name = robot.description.name
    rng = np.random.default_rng([*f"{name}/{kind}".encode(), seed])
    home = robot.spheres_at(robot.q_home)
    p_WA, reach = shoulder(robot, robot.q_home), arm_reach(robot)
    for _ in range(_TRIES):
        boards, inside = KINDS[kind](rng, p_WA[2])
        away, bearing = rng.uniform(0.35, 0.75), rng.uniform(-np.pi, np.pi)
        front = reach * away * np.array([np.cos(bearing), np.sin(bearing)])
        X_WF = RigidTransform(
            RotationMatrix.MakeZRotation(bearing + rng.uniform(-0.3, 0.3)),
            [*(p_WA[:2] + front), 0.0],
        )
        scene = PrimitiveScene(
            boxes=_placed(X_WF, boards), name=f"{kind}-{name}-{seed:04d}"
        )
        room = SignedDistanceField(scene).clearances(home, 2 * _ROOM)
        if room.minimum() > _ROOM:
            return Furniture(scene, _placed(X_WF, inside))
    raise RemoSplatError(
        f"no free place for a {kind} was found beside {name}; use another "
        "kind of scene"
    )


Boards = tuple[list[Box], list[Box]]
"""Boards, and the space for the hand, in a frame F. F is on the floor at the
middle of the front, and its x axis points inwards."""


def _shelf(rng: np.random.Generator, shoulder_height: float) -> Boards:
    wide, deep = rng.uniform(0.5, 0.9), rng.uniform(0.3, 0.45)
    bays = int(rng.integers(2, 5))
    heights = rng.uniform(0.28, 0.42, bays)
    lowest = max(shoulder_height - 0.5 * heights.sum(), _BOARD)
    levels = lowest + np.concatenate([[0.0], np.cumsum(heights)])
    low, high = levels[0], levels[-1]
    boards = [
        _box((0.0, deep), (-0.5 * wide, 0.5 * wide), (z - _BOARD, z))
        for z in levels
    ]
    for y in (-0.5 * wide - _BOARD, 0.5 * wide):
        boards.append(_box((0.0, deep), (y, y + _BOARD), (low, high)))
    back = (-0.5 * wide, 0.5 * wide)
    boards.append(_box((deep, deep + _BOARD), back, (low, high)))
    inside = [
        _box((0.0, deep), back, (z, z + height - _BOARD))
        for z, height in zip(levels, heights, strict=False)
    ]
    return boards, inside


def _open_box(rng: np.random.Generator, shoulder_height: float) -> Boards:
    wide, long = rng.uniform(0.4, 0.6, 2)
    deep = rng.uniform(0.2, 0.35)
    low = max(shoulder_height - rng.uniform(0.25, 0.6), _BOARD)
    x, y, z = (0.0, long), (-0.5 * wide, 0.5 * wide), (low, low + deep)
    boards = [_box(x, y, (low - _BOARD, low))]
    for edge in (-_BOARD, long):
        boards.append(_box((edge, edge + _BOARD), y, z))
    for edge in (-0.5 * wide - _BOARD, 0.5 * wide):
        boards.append(_box(x, (edge, edge + _BOARD), z))
    return boards, [_box(x, y, z)]


def _table(rng: np.random.Generator, shoulder_height: float) -> Boards:
    wide, deep = rng.uniform(0.8, 1.4), rng.uniform(0.5, 0.8)
    # A robot with a low shoulder cannot reach below a table of usual height.
    height = max(rng.uniform(0.55, 0.75), shoulder_height)
    x, y = (0.0, deep), (-0.5 * wide, 0.5 * wide)
    boards = [_box(x, y, (height - _BOARD, height))]
    for left in (y[0], y[1] - _LEG):
        for front in (x[0], x[1] - _LEG):
            leg = (front, front + _LEG), (left, left + _LEG)
            boards.append(_box(*leg, (0.0, height - _BOARD)))
    between = (x[0] + _LEG, x[1] - _LEG), (y[0] + _LEG, y[1] - _LEG)
    low = max(height - 0.45, 0.1)
    return boards, [_box(*between, (low, height - _BOARD))]


KINDS: dict[str, Callable[[np.random.Generator, float], Boards]] = {
    "shelf": _shelf,
    "box": _open_box,
    "under_table": _table,
}
"""The kinds of furniture, with the functions that draw them."""

Span = tuple[float, float]


def _box(x: Span, y: Span, z: Span) -> Box:
    """The box between two corners, in F."""
    lower, upper = np.transpose([x, y, z])
    return Box(RigidTransform(0.5 * (lower + upper)), 0.5 * (upper - lower))


def _placed(X_WF: RigidTransform, boxes: list[Box]) -> tuple[Box, ...]:
    return tuple(Box(X_WF @ box.X_WP, box.half_extents) for box in boxes)
