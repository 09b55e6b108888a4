"""Which spheres of the robot can meet, and how close they are."""

import dataclasses as dc
from itertools import combinations

import numpy as np
from numba import njit

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres


@dc.dataclass(frozen=True, eq=False)
class NearPairs:
    """Pairs of spheres that are close to each other, k of them.

    Attributes:
        first: Indices of one sphere of each pair, shape (k,).
        second: Indices of the other, shape (k,).
        distance: Between their surfaces, shape (k,) [m].
        direction_W: Unit vectors from the first to the second, (k, 3).
    """

    first: np.ndarray
    second: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class SelfCollisionPairs:
    """All pairs of spheres worth watching.

    Attributes:
        first: Sphere indices, shape (p,).
        second: Sphere indices, shape (p,).
        link_pair: Which pair of links each belongs to, ascending, (p,).
    """

    first: np.ndarray
    second: np.ndarray
    link_pair: np.ndarray

    def nearest(self, spheres: Spheres, within: float) -> NearPairs:
        """The closest pair of spheres of each link pair within a distance."""
        rows, distance = _nearest(
            self.first,
            self.second,
            self.link_pair,
            spheres.p_WS,
            spheres.radius,
            within,
        )
        first, second = self.first[rows], self.second[rows]
        gap = spheres.p_WS[second] - spheres.p_WS[first]
        norm = np.linalg.norm(gap, axis=1, keepdims=True)
        return NearPairs(first, second, distance, gap / np.maximum(norm, 1e-9))


def self_collision_pairs(
    robot: RobotModel, margin: float
) -> SelfCollisionPairs:
    """Sphere pairs on links that are at least two moving joints apart.

    Pairs that are nearer than `margin` in the home configuration are left
    out: there the spheres, not the robot, overlap.
    """
    links = list(dict.fromkeys(robot.spheres.links))
    on_link = {
        link: np.flatnonzero(robot.spheres.on_links({link})) for link in links
    }
    q_home = np.concatenate([np.zeros(robot.n_q - len(robot.home)), robot.home])
    spheres = robot.spheres_at(q_home)
    first: list[int] = []
    second: list[int] = []
    pair_of: list[int] = []
    number = 0
    for link_a, link_b in combinations(links, 2):
        if _joints_between(robot, link_a, link_b) < 2:
            continue
        for i in on_link[link_a]:
            for j in on_link[link_b]:
                gap = np.linalg.norm(spheres.p_WS[i] - spheres.p_WS[j])
                if gap - spheres.radius[i] - spheres.radius[j] > margin:
                    first.append(int(i))
                    second.append(int(j))
                    pair_of.append(number)
        number += 1
    return SelfCollisionPairs(
        np.array(first, np.int64),
        np.array(second, np.int64),
        np.array(pair_of, np.int64),
    )


def _joints_between(robot: RobotModel, link_a: str, link_b: str) -> int:
    """Number of moving joints on the way from one link to the other."""
    tree = robot.tree
    a = set(tree.chain(tree.index(link_a)))
    b = set(tree.chain(tree.index(link_b)))
    return sum(tree.position[body] >= 0 for body in a ^ b)


@njit(cache=True)
def _nearest(first, second, link_pair, p_WS, radius, within):
    n_pairs = link_pair[-1] + 1 if len(link_pair) else 0
    best = np.full(n_pairs, within)
    row = np.full(n_pairs, -1)
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx = p_WS[i, 0] - p_WS[j, 0]
        dy = p_WS[i, 1] - p_WS[j, 1]
        dz = p_WS[i, 2] - p_WS[j, 2]
        centre = np.sqrt(dx * dx + dy * dy + dz * dz)
        distance = centre - radius[i] - radius[j]
        if distance < best[link_pair[k]]:
            best[link_pair[k]] = distance
            row[link_pair[k]] = k
    found = row >= 0
    return row[found], best[found]
