"""Errors of a robot's link distances by shapes against those by meshes."""

import dataclasses as dc
from collections.abc import Callable
from functools import cache

import numpy as np

from apps.studies.true_shapes.maker_meshes import MakerMeshes
from remosplat_drake.robot.fitting.mesh_truth import NEAR
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sampling import random_states
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    pair_distances,
)
from remosplat_drake.robot.self_collision.link_pairs import (
    ALWAYS,
    find_link_pairs,
    pairs_between,
)
from remosplat_drake.robot.self_collision.shape_pairs import (
    LinkPair,
    ShapePairs,
)
from remosplat_drake.robot.self_collision.shapes import read_collision_shapes

STOWED = {
    "fetch": {
        "stow": (0.1, 1.32, 1.4, -0.2, 1.72, 0, 1.66, 0),
        "ready": (0.386, 1.32, 0.7, 0, -2, 0, -0.57, 0),
    }
}
"""Arm positions of named states that are not in the robots' files [m, rad]."""


@dc.dataclass(frozen=True)
class Errors:
    """Excess of link distances of meshes over those of convex shapes.

    Attributes:
        robot: The robot's name.
        named: Number of postures that its makers name, including home.
        shapes: Number of its convex shapes.
        error: All errors, shape (k,) [m].
        named_error: Errors in named postures, shape (j,) [m].
        worst: Links and distance of the largest error.
    """

    robot: str
    named: int
    shapes: int
    error: np.ndarray
    named_error: np.ndarray
    worst: str

    @property
    def row(self) -> tuple[str, ...]:
        """The cells of a table."""
        named = self.named_error.max(initial=0.0)
        return (
            self.robot,
            str(self.shapes),
            str(self.named),
            f"{1e3 * named:.1f}",
            str(len(self.error)),
            f"{1e3 * self.error.min(initial=0.0):.1f}",
            f"{1e3 * np.quantile(self.error, 0.99):.1f}",
            f"{1e3 * self.error.max():.1f}",
            self.worst,
        )


def measure(robot: RobotModel, meshes: MakerMeshes, postures: int) -> Errors:
    """Compares a robot's shapes with its meshes.

    A pair of links is left out in postures in which links on the way between
    the two intersect, unless these links intersect at home, too: no robot can
    bring the pair there.

    Args:
        robot: The robot.
        meshes: The meshes that its shapes were made from.
        postures: Number of random postures.
    """
    shapes = read_collision_shapes(robot.description, robot.spheres)
    found = find_link_pairs(robot, shapes)
    always = [p for p, why in found.left_out.items() if why == ALWAYS]
    links = [
        pair
        for pair in (*found.watched, *always)
        if set(pair) <= meshes.triangles.keys()
    ]
    pairs = ShapePairs.make(robot, shapes, links)
    arrays = pairs.arrays(np.zeros(len(pairs)))
    named = _named_states(robot, meshes)
    errors, named_errors, worst = [], [], (0.0, "none")
    between = {
        pair: pairs_between(robot, pair, meshes.triangles) for pair in links
    }
    by_design = _intersecting(robot, meshes, robot.q_home)
    nested = {
        pair for own in between.values() for pair in own if by_design(pair)
    }
    # Not the postures that importing uses.
    drawn = random_states(robot, postures, np.random.default_rng(1))
    for i, q in enumerate([*named, *drawn]):
        X_WL = robot.body_poses(q)
        distances = pair_distances(arrays, X_WL, np.inf)
        intersecting = _intersecting(robot, meshes, q)
        for pair, distance in zip(
            links, np.minimum.reduceat(distances, pairs.start[:-1]), strict=True
        ):
            if distance > NEAR:
                continue
            X_WA, X_WB = (X_WL[robot.tree.index(link)] for link in pair)
            true = meshes.distance(pair, X_WA, X_WB)
            if not 0.0 < true < NEAR:
                continue
            if any(map(intersecting, set(between[pair]) - nested)):
                continue
            error = true - distance
            errors.append(error)
            if i < len(named):
                named_errors.append(error)
            text = f"{' and '.join(pair)}, {1e3 * true:.0f} mm apart"
            worst = max(worst, (error, text))
    return Errors(
        robot.description.name,
        len(named),
        len(shapes),
        np.array(errors or [0.0]),
        np.array(named_errors),
        worst[1],
    )


def _intersecting(
    robot: RobotModel, meshes: MakerMeshes, q: np.ndarray
) -> Callable[[LinkPair], bool]:
    """Returns a function that tells if two links intersect in a posture."""
    X_WL = robot.body_poses(q)

    @cache
    def intersecting(links: LinkPair) -> bool:
        X_WA, X_WB = (X_WL[robot.tree.index(link)] for link in links)
        return meshes.intersect(links, X_WA, X_WB)

    return intersecting


def _named_states(robot: RobotModel, meshes: MakerMeshes) -> list[np.ndarray]:
    """Home and the states that makers name; joints without a name stay home."""
    joints = robot.description.arm.joints
    home = dict(zip(joints, robot.home.tolist(), strict=True))
    arms = [
        [positions.get(joint, at) for joint, at in home.items()]
        for positions in meshes.states.values()
        if any(joint in positions for joint in joints)
    ]
    arms += map(list, STOWED.get(robot.description.name, {}).values())
    base = [0.0] * (robot.n_q - len(joints))
    return [robot.q_home, *(np.array([*base, *arm]) for arm in arms)]
