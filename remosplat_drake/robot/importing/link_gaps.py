"""Finds gaps between links and their carriers, a sign of wrong units.

The links of a real arm touch at their joints. If the gap is large compared with
a link, the units of meshes and of joint origins probably differ.
"""

import dataclasses as dc
import math
from itertools import product

import numpy as np

from remosplat_drake.robot.importing.urdf import PRISMATIC, Urdf
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    pair_distances,
)
from remosplat_drake.robot.self_collision.shape_pairs import ShapePairs
from remosplat_drake.robot.self_collision.shapes import (
    CollisionShapes,
    read_collision_shapes,
)

SHARE = 0.25
"""A gap is reported if it exceeds this fraction of the smaller link's size. Of
16 robots of example-robot-data, only iCub has gaps above 0.05; its shapes are
indeed apart."""


@dc.dataclass(frozen=True)
class LinkGap:
    """A gap between a link and the link that carries it.

    Attributes:
        joint: Name of the joint that moves the link.
        link: Name of the link.
        carrier: Name of the link that carries it: the next towards the root
            that has shapes.
        distance: Least distance between the convex hulls of their shapes with
            all joints at zero, minus the travel of prismatic joints between
            them [m].
        size: Diagonal of the bounding box of the smaller link [m].
    """

    joint: str
    link: str
    carrier: str
    distance: float
    size: float

    def __str__(self) -> str:
        return (
            f"{self.link} is {1e3 * self.distance:.0f} mm away from "
            f"{self.carrier}; the smaller link is {1e3 * self.size:.0f} mm "
            "long"
        )


def find_link_gaps(urdf: Urdf, robot: RobotModel) -> list[LinkGap]:
    """Finds the links with a gap to the links that carry them.

    Links that are fixed to each other count as one, named after the link
    nearest to the root. Links without shapes are ignored.

    Args:
        urdf: The robot's links and joints.
        robot: The same robot, with its shapes.
    """
    shapes = read_collision_shapes(robot.description, robot.spheres)
    parts: dict[str, list[str]] = {}
    for link in dict.fromkeys(shapes.links):
        parts.setdefault(urdf.rigid_root(link), []).append(link)
    X_WL = robot.body_poses(np.zeros(robot.n_q))
    gaps = []
    for link, links in parts.items():
        carrier, travel = _carrier(urdf, link, parts)
        if carrier is None or math.isnan(travel):
            continue
        pairs = list(product(parts[carrier], links))
        distance = _least_distance(robot, shapes, pairs, X_WL) - travel
        size = min(
            _size(robot, shapes, some, X_WL) for some in (links, parts[carrier])
        )
        if distance > SHARE * size:
            joint = urdf.inboard[link].name
            gaps.append(LinkGap(joint, link, carrier, distance, size))
    return gaps


def _carrier(
    urdf: Urdf, link: str, parts: dict[str, list[str]]
) -> tuple[str | None, float]:
    """Returns the carrier of a link, and the travel of slides between them [m].

    The travel is NaN if a prismatic joint has no limits.
    """
    travel = 0.0
    while link in urdf.inboard:
        joint = urdf.inboard[link]
        if joint.kind == PRISMATIC:
            travel += max(abs(joint.lower), abs(joint.upper))
        link = urdf.rigid_root(joint.parent)
        if link in parts:
            return link, travel
    return None, travel


def _least_distance(
    robot: RobotModel,
    shapes: CollisionShapes,
    links: list[tuple[str, str]],
    X_WL: np.ndarray,
) -> float:
    pairs = ShapePairs.make(robot, shapes, links)
    arrays = pairs.arrays(np.zeros(len(pairs)))
    return float(pair_distances(arrays, X_WL, np.inf).min())


def _size(
    robot: RobotModel,
    shapes: CollisionShapes,
    links: list[str],
    X_WL: np.ndarray,
) -> float:
    """Returns the diagonal of the box around some links, along W's axes [m]."""
    corners = []
    for link in links:
        X = X_WL[robot.tree.index(link)]
        for shape in shapes.of(link):
            p_WV = shape.vertices @ X[:3, :3].T + X[:3, 3]
            corners += [p_WV - shape.radius, p_WV + shape.radius]
    return float(np.linalg.norm(np.ptp(np.vstack(corners), axis=0)))
