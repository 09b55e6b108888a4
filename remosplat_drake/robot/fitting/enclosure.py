"""Proves that spheres enclose a link.

A sphere model *encloses* a robot if every point on the surface of every
collision shape and of every visual mesh of each link lies inside or on a sphere
of that same link. There is no tolerance, and spheres of neighbouring links do
not count. The property therefore holds at every joint angle. Joints that the
controller does not move, such as those of a gripper's fingers, are at their
locked positions. No collision shape is then nearer to an obstacle than the
spheres, so a distance that the controller keeps for the spheres holds for the
whole robot.
"""

from typing import Protocol

import numpy as np

# Number of triangles that are processed together.
_CHUNK = 4096


class ConvexBodies(Protocol):
    """Convex bodies, such as spheres or pieces of a mesh."""

    def outside_each(self, p: np.ndarray) -> np.ndarray:
        """Computes the distance of points outside each body.

        Args:
            p: Points, shape (n, 3) [m].

        Returns:
            Shape (n, k) [m], negative inside, a convex function of the point.
        """
        ...


def standing_out(
    triangles: np.ndarray, bodies: ConvexBodies, resolution: float = 5e-5
) -> float:
    """Bounds the distance by which a surface protrudes from convex bodies [m].

    The bound holds for the whole surface, not for samples of it, since the
    point of a triangle that is farthest from a convex body is a corner. A
    triangle whose corners lie in no common body is cut into four, until each
    part lies in one body or the bound is tight.

    Args:
        triangles: Corners in the link frame, shape (t, 3, 3) [m].
        bodies: The bodies, such as the spheres of the link, in its frame.
        resolution: Largest excess of the result over the true value [m]. If a
            surface is at least that deep inside, the result is at most 0.
    """
    worst, lower = -np.inf, -np.inf
    todo = [triangles[i : i + _CHUNK] for i in range(0, len(triangles), _CHUNK)]
    while todo:
        chunk = todo.pop()
        outside = bodies.outside_each(chunk.reshape(-1, 3))
        lower = max(lower, float(outside.min(axis=1).max()))
        bound = outside.reshape(len(chunk), 3, -1).max(axis=1).min(axis=1)
        settled = bound <= max(0.0, lower + resolution)
        if settled.any():
            worst = max(worst, float(bound[settled].max()))
        if not settled.all():
            todo.append(in_four(chunk[~settled]))
    return worst


def in_four(triangles: np.ndarray) -> np.ndarray:
    """Cuts each triangle into four at the midpoints of its edges.

    Args:
        triangles: Corners, shape (t, 3, 3) [m].

    Returns:
        Shape (4t, 3, 3) [m].
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
