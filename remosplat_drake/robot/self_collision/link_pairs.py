"""Chooses the pairs of a robot's links to check for self-collision.

Pairs are excluded as in MoveIt's setup assistant (Coleman et al. 2014): by
their positions in the tree, by the description, and by random configurations.
The random configurations are always the same.
"""

import dataclasses as dc
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path

import numpy as np

from remosplat_drake.base import resources
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sampling import random_states
from remosplat_drake.robot.self_collision.kernels.all_distances import (
    count_contacts,
)
from remosplat_drake.robot.self_collision.shape_pairs import (
    LinkPair,
    ShapePairs,
)
from remosplat_drake.robot.self_collision.shapes import CollisionShapes
from remosplat_drake.robot.srdf import read_disabled_collisions

ADJACENT = "adjacent"
"""Reason for an exclusion: the links are fewer than two moving joints apart, so
they meet at a joint."""

ALLOWED = "allowed"
"""Reason for an exclusion: the description or SRDF excludes the pair from
collision checks."""

ALWAYS = "always"
"""Reason for an exclusion: the links overlap at home and in all samples, so the
shapes are wrong.

MoveIt excludes a pair that overlaps in 95 % of the samples. But links that are
often folded may really touch in most configurations.
"""

SAMPLES = 1000
"""Number of configurations in which overlaps are examined: home and random
ones."""


@dc.dataclass(frozen=True, eq=False)
class LinkPairs:
    """The checked and the excluded pairs of a robot's links.

    Attributes:
        watched: The checked pairs, which must not touch, in the order of the
            tree.
        left_out: The excluded pairs, with the reason `ADJACENT`, `ALLOWED` or
            `ALWAYS`.
        contacts: Fraction of the samples in which each checked pair overlaps.
    """

    watched: tuple[LinkPair, ...]
    left_out: dict[LinkPair, str]
    contacts: dict[LinkPair, float]

    @property
    def never(self) -> tuple[LinkPair, ...]:
        """The checked pairs that overlap in no sample.

        MoveIt excludes these pairs to save time. This package checks them,
        since samples do not prove that they never overlap, and a coarse check
        of such a pair takes nanoseconds.
        """
        return tuple(p for p in self.watched if not self.contacts[p])

    def with_payload(
        self, robot: RobotModel, payload: Payload, shapes: CollisionShapes
    ) -> "LinkPairs":
        """Returns the pairs, with additional pairs of payload and links.

        The payload is checked against all links except those that hold it and
        those that cannot move relative to it. A link one joint away is checked,
        since the payload is not at a joint.

        Args:
            robot: The robot with the payload.
            payload: The payload.
            shapes: All convex shapes, the payload's among them.
        """
        name, left_out = payload.name, dict(self.left_out)
        candidates = []
        for link in dict.fromkeys(shapes.links):
            if link == name:
                continue
            if not joints_between(robot, link, name):
                left_out[link, name] = ADJACENT
            elif link in payload.holders:
                left_out[link, name] = ALLOWED
            else:
                candidates.append((link, name))
        shares = _contacts(robot, shapes, candidates)
        always = [pair for pair, share in shares.items() if share == 1.0]
        left_out |= dict.fromkeys(always, ALWAYS)
        watched = [pair for pair in candidates if pair not in always]
        contacts = {pair: shares[pair] for pair in watched}
        return LinkPairs(
            (*self.watched, *watched), left_out, self.contacts | contacts
        )


def find_link_pairs(robot: RobotModel, shapes: CollisionShapes) -> LinkPairs:
    """Determines which pairs of links are checked.

    Args:
        robot: The robot.
        shapes: The robot's convex shapes.

    Raises:
        FileError: The SRDF file of its description cannot be read.
    """
    candidates, left_out = possible_pairs(robot, shapes.links)
    shares = _contacts(robot, shapes, candidates)
    for links_ab, share in shares.items():
        if share == 1.0:
            left_out[links_ab] = ALWAYS
    watched = tuple(p for p in candidates if p not in left_out)
    return LinkPairs(watched, left_out, {p: shares[p] for p in watched})


def possible_pairs(
    robot: RobotModel, links: Iterable[str]
) -> tuple[list[LinkPair], dict[LinkPair, str]]:
    """Finds the pairs of links that may collide, regardless of their shapes.

    Args:
        robot: The robot.
        links: Names of links.

    Returns:
        These pairs in the order of the tree, and the excluded pairs with their
        reasons, `ADJACENT` or `ALLOWED`.

    Raises:
        FileError: The SRDF file of its description cannot be read.
    """
    allowed = _allowed(robot)
    rank = {name: i for i, name in enumerate(robot.tree.names)}
    left_out: dict[LinkPair, str] = {}
    candidates = []
    for a, b in combinations(sorted(set(links), key=rank.__getitem__), 2):
        if joints_between(robot, a, b) < 2:
            left_out[a, b] = ADJACENT
        elif frozenset((a, b)) in allowed:
            left_out[a, b] = ALLOWED
        else:
            candidates.append((a, b))
    return candidates, left_out


def joints_between(robot: RobotModel, link_a: str, link_b: str) -> int:
    """Returns the number of moving joints between two links."""
    tree = robot.tree
    a = set(tree.chain(tree.index(link_a)))
    b = set(tree.chain(tree.index(link_b)))
    return sum(tree.position[body] >= 0 for body in a ^ b)


def pairs_between(
    robot: RobotModel, links: LinkPair, among: Iterable[str]
) -> list[LinkPair]:
    """Finds the pairs of links that may collide on the way between two links.

    The pose of one link in the other depends only on the joints between them.
    So if two links on the way touch, the robot cannot bring the two given links
    into this relative pose.

    Args:
        robot: The robot.
        links: Names of two links.
        among: Names of links; all others are ignored.

    Returns:
        The pairs, without the given one.
    """
    tree = robot.tree
    a, b = (tree.chain(tree.index(link)) for link in links)
    shared = [x for x, y in zip(a, b, strict=False) if x == y]
    way = {*shared[-1:], *(set(a) ^ set(b))}
    names = {tree.names[body] for body in way} & set(among)
    pairs, _ = possible_pairs(robot, names)
    return [pair for pair in pairs if set(pair) != set(links)]


def _allowed(robot: RobotModel) -> set[frozenset[str]]:
    """The pairs that the description and its SRDF file allow to collide."""
    description = robot.description
    allowed = {frozenset(pair) for pair in description.allowed_collisions}
    if description.srdf:
        folder = Path(description.source).parent
        path = resources.resolve(description.srdf, folder)
        # An SRDF may name links that this model does not have.
        allowed |= {frozenset(p) for p in read_disabled_collisions(path)}
    return allowed


def _contacts(
    robot: RobotModel, shapes: CollisionShapes, links: list[LinkPair]
) -> dict[LinkPair, float]:
    """Computes the fraction of random configurations in which links overlap."""
    pairs = ShapePairs.make(robot, shapes, links)
    states = random_states(robot, SAMPLES - 1, np.random.default_rng(0))
    counts = count_contacts(
        robot.tree.arrays,
        pairs.arrays(np.zeros(len(pairs))),
        np.vstack([robot.q_home, states]),
    )
    return dict(zip(links, (counts / SAMPLES).tolist(), strict=True))
