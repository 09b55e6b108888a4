"""The families of random scenes, as functions of a random generator.

`table` and `bookshelf` are the families of the RMMI benchmark: clutter of
upright cylinders in front of one fixed end-effector target, in the ranges of
the 1,000 published scenes. `table2`, `bookshelf2` and `posts` are our own
families, which test a controller outside the scenes with which it was tuned.
They also vary the goal and the whole start pose. `room.py` contains a family
with long drives. All lengths are in metres, all angles in radians.
"""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

LOWER_SHELF_MAX_Z = 0.552
MIDDLE_SHELF_MIN_Z = 0.953
"""Smallest height of the middle shelf's centre [m]. Published scenes with a
lower shelf were all infeasible."""

_BOARD = 0.03
"""Half the thickness of table tops and shelves [m]."""


def table(rng: np.random.Generator, name: str) -> PrimitiveScene:
    """Makes a scene of a table top and four cylinders that pass through it.

    At the target, the gripper points down.
    """
    top = box([1.5, 0, 0.5 + rng.uniform(-0.1, 0.1)], [0.5, 2.0, _BOARD])
    cylinders = tuple(
        upright_cylinder(
            np.array([1.1, 0, 0.5])
            + rng.uniform(-1, 1, 3) * np.array([0.1, 0.25, 0]),
            radius=0.05 + rng.uniform(-0.03, 0.03),
            half_height=0.3 + rng.uniform(-0.2, 0.2),
        )
        for _ in range(4)
    )
    return PrimitiveScene(
        boxes=(top,),
        cylinders=cylinders,
        X_WE_target=RigidTransform(
            RotationMatrix(np.diag([1.0, -1.0, -1.0])),
            [1.15349, -0.00112, 0.65838],
        ),
        X_WB_start=(0.0, rng.uniform(-0.5, 0.5), 0.0),
        name=name,
    )


def bookshelf(rng: np.random.Generator, name: str) -> PrimitiveScene:
    """Makes a scene of a shelf with two thin columns in front of it.

    The shelf has three boards and two sides.
    """
    boxes = _shelf(
        lower=rng.uniform(0.4, LOWER_SHELF_MAX_Z),
        middle=rng.uniform(MIDDLE_SHELF_MIN_Z, 1.0),
    )
    cylinders = tuple(
        upright_cylinder(
            np.array([0.9, 0, 0.6])
            + rng.uniform(-1, 1, 3) * np.array([0.1, 0.4, 0]),
            radius=0.03 + rng.uniform(-0.02, 0.02),
            half_height=0.5,
        )
        for _ in range(2)
    )
    return PrimitiveScene(
        boxes=boxes,
        cylinders=cylinders,
        X_WE_target=RigidTransform(
            RotationMatrix.ProjectToRotationMatrix(
                np.array([[1, 0.0047, 0], [0.0047, -1, 0], [0, 0, -1]])
            ),
            [1.18035, 0.04827, 0.60746],
        ),
        X_WB_start=(0.0, rng.uniform(-1.0, 1.0), 0.0),
        name=name,
    )


def table2(rng: np.random.Generator, name: str) -> PrimitiveScene:
    """Makes a scene of six cylinders on a table, with a random goal among them.

    - Table top: as in `table`, its centre at z in [0.4, 0.6].
    - Cylinders: x in [1.05, 1.35], y in [-0.4, 0.4], radius in [0.02, 0.07],
      height in [0.1, 0.5].
    - Goal: x in [1.1, 1.25], y in [-0.25, 0.25], 0.08 to 0.25 above the top;
      the gripper points down and is turned by up to pi/4.
    - Start: base at x in [-0.3, 0.1], y in [-0.8, 0.8], yaw in [-0.6, 0.6].
    """
    z = rng.uniform(0.4, 0.6)
    top = z + _BOARD
    goal = rng.uniform([1.1, -0.25, top + 0.08], [1.25, 0.25, top + 0.25])
    cylinders = []
    for _ in range(6):
        x, y = rng.uniform([1.05, -0.4], [1.35, 0.4])
        half_height = rng.uniform(0.05, 0.25)
        cylinders.append(
            upright_cylinder(
                np.array([x, y, top + half_height]),
                radius=rng.uniform(0.02, 0.07),
                half_height=half_height,
            )
        )
    return PrimitiveScene(
        boxes=(box([1.5, 0, z], [0.5, 2.0, _BOARD]),),
        cylinders=tuple(cylinders),
        X_WE_target=gripper_down(goal, rng),
        X_WB_start=draw_start(rng),
        name=name,
    )


def bookshelf2(rng: np.random.Generator, name: str) -> PrimitiveScene:
    """Makes a scene of three thin columns before a shelf with a goal inside it.

    - Shelf: as in `bookshelf`.
    - Columns: x in [0.75, 1.0], y in [-0.5, 0.5], radius in [0.01, 0.05],
      from z = 0.1 to 1.1 as in `bookshelf`.
    - Goal: x in [1.0, 1.15], y in [-0.25, 0.25], 0.05 to 0.12 above the
      lower shelf; the gripper points down and is turned by up to pi/4.
    - Start: base at x in [-0.3, 0.1], y in [-0.8, 0.8], yaw in [-0.6, 0.6].
    """
    lower = rng.uniform(0.4, LOWER_SHELF_MAX_Z)
    top = lower + _BOARD
    boxes = _shelf(lower, middle=rng.uniform(MIDDLE_SHELF_MIN_Z, 1.0))
    goal = rng.uniform([1.0, -0.25, top + 0.05], [1.15, 0.25, top + 0.12])
    columns = tuple(
        upright_cylinder(
            rng.uniform([0.75, -0.5, 0.6], [1.0, 0.5, 0.6]),
            radius=rng.uniform(0.01, 0.05),
            half_height=0.5,
        )
        for _ in range(3)
    )
    return PrimitiveScene(
        boxes=boxes,
        cylinders=columns,
        X_WE_target=gripper_down(goal, rng),
        X_WB_start=draw_start(rng),
        name=name,
    )


def posts(rng: np.random.Generator, name: str) -> PrimitiveScene:
    """Makes a scene of five posts on the floor with a goal between two posts.

    - Goal: x in [1.1, 1.3], y in [-0.3, 0.3], z in [0.5, 0.9]; the gripper
      points along +x, turned sideways by up to 0.4 and rolled by any angle.
    - Gate: a post on either side of the goal, its axis 0.14 to 0.24 away in
      y and at most 0.12 before or behind it in x.
    - Three more posts: x in [0.8, 1.5], y in [-0.7, 0.7].
    - All posts: radius in [0.02, 0.05], from the floor to z in [0.8, 1.4].
    - Start: base at x in [-0.3, 0.1], y in [-0.8, 0.8], yaw in [-0.6, 0.6].
    """
    goal = rng.uniform([1.1, -0.3, 0.5], [1.3, 0.3, 0.9])
    gate = [
        goal[:2]
        + np.array([rng.uniform(-0.12, 0.12), side * rng.uniform(0.14, 0.24)])
        for side in (-1, 1)
    ]
    others = rng.uniform([0.8, -0.7], [1.5, 0.7], (3, 2))
    cylinders = []
    for xy in (*gate, *others):
        half_height = rng.uniform(0.4, 0.7)
        cylinders.append(
            upright_cylinder(
                np.array([*xy, half_height]),
                radius=rng.uniform(0.02, 0.05),
                half_height=half_height,
            )
        )
    turn = RotationMatrix.MakeZRotation(rng.uniform(-0.4, 0.4))
    level = RollPitchYaw(0.0, np.pi / 2, 0.0).ToRotationMatrix()
    roll = RotationMatrix.MakeZRotation(rng.uniform(-np.pi, np.pi))
    return PrimitiveScene(
        cylinders=tuple(cylinders),
        X_WE_target=RigidTransform(turn @ level @ roll, goal),
        X_WB_start=draw_start(rng),
        name=name,
    )


def draw_start(rng: np.random.Generator) -> tuple[float, float, float]:
    """Draws a start pose (x, y, yaw) of the base, uniformly [m, rad].

    The ranges are [-0.3, 0.1] for x, [-0.8, 0.8] for y, and [-0.6, 0.6] for
    yaw.
    """
    x, y, yaw = rng.uniform([-0.3, -0.8, -0.6], [0.1, 0.8, 0.6])
    return float(x), float(y), float(yaw)


def gripper_down(p_WE: np.ndarray, rng: np.random.Generator) -> RigidTransform:
    """Draws a target pose at p_WE at which the gripper points down.

    The pose is turned by up to pi/4 about the vertical axis.
    """
    turn = RotationMatrix.MakeZRotation(rng.uniform(-np.pi / 4, np.pi / 4))
    down = RotationMatrix(np.diag([1.0, -1.0, -1.0]))
    return RigidTransform(turn @ down, p_WE)


def _shelf(lower: float, middle: float) -> tuple[Box, ...]:
    """Makes a shelf; its lower boards have their centres at these heights."""
    return (
        box([1.4, 0, lower], [0.5, 0.6, _BOARD]),
        box([1.4, -0.6, 0.6], [0.5, 0.03, 0.6]),
        box([1.4, 0, middle], [0.5, 0.6, _BOARD]),
        box([1.4, 0.6, 0.6], [0.5, 0.05, 0.6]),
        box([1.4, 0, 1.2], [0.5, 0.6, _BOARD]),
    )


def box(center: list[float], half_extents: list[float]) -> Box:
    """Makes a box [m] with sides parallel to the axes of W."""
    return Box(RigidTransform(np.array(center)), np.array(half_extents))


def upright_cylinder(
    center: np.ndarray, radius: float, half_height: float
) -> Cylinder:
    """Makes a cylinder [m] with a vertical axis."""
    return Cylinder(RigidTransform(center), radius, half_height)
