"""The family `room`: two rooms, a doorway, and a table behind it.

The targets require long drives: at the start, the robot faces away from the
goal, at a distance of five to eight metres, and the straight path leads through
a wall.
"""

import numpy as np

from remosplat_drake.generation.scene_families import (
    box,
    gripper_down,
    upright_cylinder,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

LENGTH, WIDTH, HEIGHT = 4.2, 5.0, 1.8
"""Extent of each room along x and y, and height of the walls [m]."""

_WALL, _TOP, _LEG = 0.05, 0.02, 0.025
"""Half the thickness of walls, table top and legs [m]."""

_TABLE = (0.4, 0.7)
"""Half the length and half the width of the table [m]."""


def room(rng: np.random.Generator, name: str) -> PrimitiveScene:
    """Makes a scene of a table with three cylinders behind a wall's doorway.

    - Wall: at x = 0; its doorway is 0.95 to 1.15 wide, its middle at y in
      [-1.6, 1.6].
    - Table: in the room at x > 0, its middle at x in [2.5, 3.2], y in [-1.5,
      1.5], its top at z in [0.65, 0.78].
    - Cylinders: on the table, radius in [0.02, 0.05], height in [0.1, 0.3].
    - Goal: above the table, 0.08 to 0.2 from the edge that faces the wall and
      0.1 to 0.2 above the top; the gripper points down and is turned by up to
      pi/4.
    - Start: in the room at x < 0, x in [-3.4, -2.8], y in [-1.5, 1.5]; the
      base faces away from the wall, turned by up to 0.6.
    """
    door, half_width = rng.uniform(-1.6, 1.6), rng.uniform(0.475, 0.575)
    x, y = rng.uniform([2.5, -1.5], [3.2, 1.5])
    top = rng.uniform(0.65, 0.78)
    edge = x - _TABLE[0]
    goal = rng.uniform(
        [edge + 0.08, y - 0.4, top + 0.1], [edge + 0.2, y + 0.4, top + 0.2]
    )
    cylinders = []
    for _ in range(3):
        radius, half_height = rng.uniform([0.02, 0.05], [0.05, 0.15])
        cx, cy = rng.uniform([edge + 0.05, y - 0.6], [edge + 0.5, y + 0.6])
        cylinders.append(
            upright_cylinder(
                np.array([cx, cy, top + half_height]), radius, half_height
            )
        )
    start_x, start_y, turn = rng.uniform([-3.4, -1.5, -0.6], [-2.8, 1.5, 0.6])
    return PrimitiveScene(
        boxes=(*_walls(door, half_width), *_table(x, y, top)),
        cylinders=tuple(cylinders),
        X_WE_target=gripper_down(goal, rng),
        X_WB_start=(
            float(start_x),
            float(start_y),
            float(turn - np.copysign(np.pi, turn)),
        ),
        name=name,
    )


def _walls(door: float, half_width: float) -> list[Box]:
    """Four walls around both rooms, and two beside the doorway."""
    z, side = HEIGHT / 2, WIDTH / 2
    walls = [
        box([sign * (LENGTH + _WALL), 0, z], [_WALL, side + 2 * _WALL, z])
        for sign in (-1, 1)
    ]
    walls += [
        box([0, sign * (side + _WALL), z], [LENGTH, _WALL, z])
        for sign in (-1, 1)
    ]
    for lower, upper in (
        (-side, door - half_width),
        (door + half_width, side),
    ):
        middle, half = (lower + upper) / 2, (upper - lower) / 2
        walls.append(box([0, middle, z], [_WALL, half, z]))
    return walls


def _table(x: float, y: float, top: float) -> list[Box]:
    """A table top on four legs, which stand at its corners."""
    length, width = _TABLE
    half = (top - 2 * _TOP) / 2
    legs = [
        box(
            [x + a * (length - _LEG), y + b * (width - _LEG), half],
            [_LEG, _LEG, half],
        )
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    return [box([x, y, top - _TOP], [length, width, _TOP]), *legs]
