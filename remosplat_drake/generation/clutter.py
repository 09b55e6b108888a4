"""Generates random scenes of posts and beams around any robot."""

from collections.abc import Callable

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.generation.scene_families import upright_cylinder
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.reach import arm_reach, shoulder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

POSTS, BEAMS = 5, 3
"""A scene has at most this many posts (first number) and at most this many
beams (second number)."""

_ROOM = 0.15
"""Posts and beams are at least this far from the robot in its home
configuration [m]."""

_TRIES = 200
"""For each post or beam, this many random draws are tried. If none of them
fits, the post or beam is omitted."""


def clutter(robot: RobotModel, seed: int) -> PrimitiveScene:
    """Generates a scene around a robot that stands at the origin.

    - Posts: up to 5, from the floor to a height between 0.5 m and 0.6 of the
      arm's reach above the shoulder, radius in [0.02, 0.05].
    - Beams: up to 3, level, 0.2 to 0.7 m long and 0.06 m thick, at heights from
      half the shoulder's height to 0.8 of the reach above the shoulder.
    - Both: at least 0.3 m from the shoulder, and at most 0.9 of the reach for a
      fixed robot, or twice the reach for a mobile robot.

    Args:
        robot: The robot.
        seed: Any non-negative integer; with the robot's name, it determines the
            scene.
    """
    name = robot.description.name
    rng = np.random.default_rng([*name.encode(), seed])
    home = robot.spheres_at(robot.q_home)
    p_WA, reach = shoulder(robot, robot.q_home), arm_reach(robot)
    far = reach * (2.0 if robot.n_base else 0.9)

    def place() -> np.ndarray:
        away, bearing = rng.uniform(0.3, far), rng.uniform(-np.pi, np.pi)
        return p_WA[:2] + away * np.array([np.cos(bearing), np.sin(bearing)])

    def post() -> PrimitiveScene:
        half = 0.5 * rng.uniform(0.5, p_WA[2] + 0.6 * reach)
        center, radius = np.array([*place(), half]), rng.uniform(0.02, 0.05)
        solid = upright_cylinder(center, radius, half)
        return PrimitiveScene(cylinders=(solid,))

    def beam() -> PrimitiveScene:
        height = rng.uniform(0.5 * p_WA[2] + 0.15, p_WA[2] + 0.8 * reach)
        turn = RotationMatrix.MakeZRotation(rng.uniform(-np.pi, np.pi))
        half = np.array([rng.uniform(0.1, 0.35), 0.03, 0.03])
        solid = Box(RigidTransform(turn, [*place(), height]), half)
        return PrimitiveScene(boxes=(solid,))

    def fitting(draw: Callable[[], PrimitiveScene], count: int):
        found: list[PrimitiveScene] = []
        for _ in range(count * _TRIES):
            alone = draw()
            room = SignedDistanceField(alone).clearances(home, 2 * _ROOM)
            if room.minimum() > _ROOM:
                found.append(alone)
            if len(found) == count:
                break
        return found

    return PrimitiveScene(
        cylinders=tuple(s.cylinders[0] for s in fitting(post, POSTS)),
        boxes=tuple(s.boxes[0] for s in fitting(beam, BEAMS)),
        name=f"clutter-{name}-{seed:04d}",
    )
