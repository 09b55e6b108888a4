"""Finds links whose collision shapes overlap in an implausible way.

Self-collision does not check links that overlap in every posture, since the
robot could not move otherwise. A hull that contains its whole neighbour was
probably made from the wrong mesh, or from a mesh in another unit.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.link_pairs import (
    ADJACENT,
    ALWAYS,
    find_link_pairs,
    joints_between,
)
from remosplat_drake.robot.self_collision.shape_pairs import LinkPair
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    ConvexShape,
    read_collision_shapes,
)


def doubt_overlaps(robot: RobotModel, findings: Findings) -> None:
    """Reports shapes that overlap in every posture, or contain a neighbour.

    Args:
        robot: The robot.
        findings: Receives the doubts.
    """
    shapes = read_collision_shapes(robot.description, robot.spheres)
    left_out = find_link_pairs(robot, shapes).left_out
    always = [pair for pair, why in left_out.items() if why == ALWAYS]
    if always:
        findings.doubt(
            "self-collision",
            f"{_worded(always)} overlap in every pose, and are not checked",
        )
    held = [
        held
        for pair, why in left_out.items()
        if why == ADJACENT and (held := _held(robot, shapes, pair))
    ]
    if held:
        findings.doubt(
            "collision shapes",
            listed([f"that of {a} contains {b}" for a, b in held], 3)
            + "; are their meshes, scales and origins right?",
        )


def _worded(pairs: list[LinkPair]) -> str:
    return listed([f"{a} and {b}" for a, b in pairs], 3)


def _held(
    robot: RobotModel, shapes: CollisionShapes, pair: LinkPair
) -> LinkPair | None:
    """Returns the link of a pair that contains the other at home, or None."""
    if joints_between(robot, *pair) == 0:
        return None  # Parts of one body may overlap.
    X_WL = robot.body_poses(robot.q_home)
    for outer, inner in (pair, pair[::-1]):
        X_OI = np.linalg.solve(
            X_WL[robot.tree.index(outer)], X_WL[robot.tree.index(inner)]
        )
        holders, held = shapes.of(outer), shapes.of(inner)
        within = [_holds(shape, held, X_OI) for shape in holders]
        if np.any(within, axis=0).all():
            return outer, inner
    return None


def _holds(
    outer: ConvexShape, inner: Sequence[ConvexShape], X_OI: np.ndarray
) -> list[bool]:
    """Whether a shape contains other shapes; flat or thin shapes do not."""
    try:
        planes = ConvexHull(outer.vertices).equations
    except (QhullError, ValueError):
        return [False] * len(inner)
    holds = []
    for shape in inner:
        p_O = shape.vertices @ X_OI[:3, :3].T + X_OI[:3, 3]
        height = p_O @ planes[:, :3].T + planes[:, 3]
        holds.append(bool(height.max() + shape.radius <= outer.radius))
    return holds
