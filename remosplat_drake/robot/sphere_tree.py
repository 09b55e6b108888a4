"""`SphereTree`: balls around spheres of a link, for fewer distance queries.

A lower bound on the distance from a ball holds for all spheres inside it. A
ball moves with its link like a sphere, so the same bounds on motion apply.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from remosplat_drake.robot.sphere_model import SphereModel

_LARGEST = 0.2
"""A ball with several spheres is split if its radius exceeds this [m]."""

_STEPS = 100
"""The centre of the smallest enclosing ball is approached in this many steps.
"""


class SphereTree(NamedTuple):
    """g balls around n spheres, followed by these spheres: m = g + n in all.

    Attributes:
        body: Body of each ball and sphere, shape (m,).
        p_LS: Centres in their links, shape (m, 3) [m].
        radius: Radii, shape (m,) [m].
        ignore_below: Height below which each ignores the map, shape (m,) [m].
        index: Index of the sphere; -1 for a ball, shape (m,).
        hessian_bound: Bounds on |d2p_WS / dq_j dq_k|, shape (m, n_u, n_u).
        first: Index in `member` of each ball's first sphere; the last entry is
            n, shape (g + 1,).
        member: The spheres sorted by ball, as indices among the m, shape (n,).
    """

    body: np.ndarray
    p_LS: np.ndarray
    radius: np.ndarray
    ignore_below: np.ndarray
    index: np.ndarray
    hessian_bound: np.ndarray
    first: np.ndarray
    member: np.ndarray

    @staticmethod
    def make(
        spheres: SphereModel,
        body_S: np.ndarray,
        ignore_below: np.ndarray,
        bend: Callable[[np.ndarray, np.ndarray], np.ndarray],
    ) -> "SphereTree":
        """Puts balls around the spheres of a robot.

        Args:
            spheres: The n spheres.
            body_S: Bodies of the spheres, shape (n,).
            ignore_below: Height below which each ignores the map, shape (n,)
                [m].
            bend: Function that bounds |d2p_WP / dq_j dq_k| of points P, given
                their bodies, shape (k,), and positions in these, shape (k, 3)
                [m].
        """
        groups = _groups(spheres)
        around = [
            enclosing_ball(spheres.p_LS[group], spheres.radius[group])
            for group in groups
        ]
        leader = np.array([group[0] for group in groups])
        body = np.concatenate([body_S[leader], body_S])
        p_LS = np.concatenate([[p_LB for p_LB, _ in around], spheres.p_LS])
        return SphereTree(
            body,
            p_LS,
            np.concatenate([[radius for _, radius in around], spheres.radius]),
            np.concatenate([ignore_below[leader], ignore_below]),
            np.concatenate([np.full(len(groups), -1), np.arange(len(spheres))]),
            bend(body, p_LS),
            np.cumsum([0, *map(len, groups)]),
            len(groups) + np.concatenate(groups),
        )


def _groups(spheres: SphereModel) -> list[np.ndarray]:
    """Divides the spheres of each link into groups for enclosing balls."""
    links = np.array(spheres.links)
    left = [
        np.flatnonzero(links == link) for link in dict.fromkeys(spheres.links)
    ]
    groups = []
    while left:
        group = left.pop()
        p_LS = spheres.p_LS[group]
        _, radius = enclosing_ball(p_LS, spheres.radius[group])
        if len(group) == 1 or radius <= _LARGEST:
            groups.append(group)
            continue
        along = p_LS[:, np.argmax(np.ptp(p_LS, axis=0))]
        order = group[np.argsort(along, kind="stable")]
        left.extend(np.array_split(order, 2))
    return groups[::-1]


def enclosing_ball(
    centers: np.ndarray, radius: np.ndarray
) -> tuple[np.ndarray, float]:
    """Finds a ball around balls, hardly larger than the smallest such ball.

    The centre moves towards the farthest ball in ever smaller steps (Badoiu and
    Clarkson 2003).

    Args:
        centers: Centres of the given balls, shape (k, 3) [m].
        radius: Radii of the given balls, shape (k,) [m].

    Returns:
        Centre of the found ball, shape (3,) [m], and its radius [m].
    """
    center = centers.mean(axis=0)
    for step in range(2, _STEPS):
        away = np.linalg.norm(centers - center, axis=1) + radius
        center = center + (centers[away.argmax()] - center) / step
    away = np.linalg.norm(centers - center, axis=1) + radius
    return center, float(away.max())
