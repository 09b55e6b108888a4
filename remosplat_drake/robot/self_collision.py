"""Self-collision: pairs of the robot's spheres, and their distances.

Where the spheres enclose the robot (see `enclosure`), links whose spheres do
not overlap do not touch. Links that are fewer than two moving joints apart are
not watched: at their common joint they always meet.
"""

import dataclasses as dc
from itertools import combinations, count, product

import numpy as np
from numba import njit

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres

# How much nearer than at home spheres may come that overlap there [m].
_WOBBLE = 0.005


@dc.dataclass(frozen=True, eq=False)
class NearPairs:
    """k pairs of the robot's spheres that are close to each other.

    Attributes:
        first: Index of one sphere of each pair, shape (k,).
        second: Index of the other sphere, shape (k,).
        distance: Distance between their surfaces plus the pair's allowance,
            shape (k,) [m].
        direction_W: Unit vectors from the first centre to the second, in W,
            shape (k, 3).
    """

    first: np.ndarray
    second: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class SelfCollisionPairs:
    """All p pairs of the robot's spheres that are worth watching.

    Attributes:
        first: Index of one sphere of each pair, shape (p,).
        second: Index of the other sphere, shape (p,).
        link_pair: Number of the pair of links that each belongs to, shape (p,).
            Of a pair of links only the nearest spheres count; spheres with an
            allowance count alone.
        allowance: How much nearer than others the spheres may come, shape (p,)
            [m].
    """

    first: np.ndarray
    second: np.ndarray
    link_pair: np.ndarray
    allowance: np.ndarray

    def nearest(self, spheres: Spheres, within: float) -> NearPairs:
        """Finds the closest pair of spheres of each link pair.

        Args:
            spheres: The robot's spheres, placed in W.
            within: Pairs at or beyond this distance are left out [m].
        """
        rows, distance = _nearest(
            self.first,
            self.second,
            self.link_pair,
            self.allowance,
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
    """Lists sphere pairs on links that are at least two moving joints apart.

    Spheres at a short wrist may be nearer than `margin` in the home
    configuration already. Such a pair gets an allowance and counts alone, so
    that it hides no other: it may come so near that the spheres touch, or, if
    they overlap at home, hardly nearer than they are there.
    """
    on_link: dict[str, list[int]] = {}
    for i, link in enumerate(robot.spheres.links):
        on_link.setdefault(link, []).append(i)
    spheres = robot.spheres_at(robot.q_home)
    pairs: list[tuple[int, int, int]] = []
    allowances: list[float] = []
    numbers = count()
    for link_a, link_b in combinations(on_link, 2):
        if _joints_between(robot, link_a, link_b) < 2:
            continue
        together = next(numbers)
        for i, j in product(on_link[link_a], on_link[link_b]):
            gap = np.linalg.norm(spheres.p_WS[i] - spheres.p_WS[j])
            home = gap - spheres.radius[i] - spheres.radius[j]
            if home > margin:
                pairs.append((i, j, together))
                allowances.append(0.0)
            else:
                lowest = 0.0 if home >= 0 else home - _WOBBLE
                pairs.append((i, j, next(numbers)))
                allowances.append(margin - lowest)
    first, second, number = np.array(pairs, np.int64).reshape(-1, 3).T.copy()
    return SelfCollisionPairs(
        first, second, number, np.array(allowances, float)
    )


def _joints_between(robot: RobotModel, link_a: str, link_b: str) -> int:
    """Number of moving joints on the way from one link to the other."""
    tree = robot.tree
    a = set(tree.chain(tree.index(link_a)))
    b = set(tree.chain(tree.index(link_b)))
    return sum(tree.position[body] >= 0 for body in a ^ b)


@njit(cache=True)
def _nearest(first, second, link_pair, allowance, p_WS, radius, within):
    n_pairs = link_pair.max() + 1 if len(link_pair) else 0
    best = np.full(n_pairs, within)
    row = np.full(n_pairs, -1)
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx = p_WS[i, 0] - p_WS[j, 0]
        dy = p_WS[i, 1] - p_WS[j, 1]
        dz = p_WS[i, 2] - p_WS[j, 2]
        centre = np.sqrt(dx * dx + dy * dy + dz * dz)
        distance = centre - radius[i] - radius[j] + allowance[k]
        if distance < best[link_pair[k]]:
            best[link_pair[k]] = distance
            row[link_pair[k]] = k
    found = row >= 0
    return row[found], best[found]
