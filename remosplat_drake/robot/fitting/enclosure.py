"""What it means that spheres enclose a link, and the proof of it.

A sphere model *encloses* a robot if every point on the surface of every
collision shape and of every visual mesh of each link lies inside or on a
sphere of that same link. No tolerance is granted and no neighbouring link
helps out, so this holds at every joint angle; it holds for joints that the
controller does not move (a gripper's fingers) where they are locked. Then no
collision shape is nearer to anything than the spheres are: a distance that
the controller keeps for the spheres, every station keeps for the robot.
"""

import numpy as np

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres

# Triangles that are looked at together.
_CHUNK = 4096


def standing_out(
    triangles: np.ndarray, spheres: LinkSpheres, resolution: float = 5e-5
) -> float:
    """Bounds how far a surface stands out of the union of spheres [m].

    This is a bound for the whole surface, not for samples of it: the point of a
    triangle that is farthest from a sphere is a corner. A triangle whose
    corners are in no common sphere is cut in four until they are, or until the
    bound is sharp.

    Args:
        triangles: Corners in the link frame, shape (t, 3, 3) [m].
        spheres: The spheres of the link.
        resolution: How much too large the result may be [m]. A surface that is
            enclosed with so much to spare has a result of at most 0.
    """
    worst, lower = -np.inf, -np.inf
    todo = [triangles[i : i + _CHUNK] for i in range(0, len(triangles), _CHUNK)]
    while todo:
        chunk = todo.pop()
        outside = spheres.outside_each(chunk.reshape(-1, 3))
        lower = max(lower, float(outside.min(axis=1).max()))
        bound = outside.reshape(len(chunk), 3, -1).max(axis=1).min(axis=1)
        settled = bound <= max(0.0, lower + resolution)
        if settled.any():
            worst = max(worst, float(bound[settled].max()))
        if not settled.all():
            todo.append(_in_four(chunk[~settled]))
    return worst


def _in_four(triangles: np.ndarray) -> np.ndarray:
    """Cuts triangles at the middles of their edges, (t, 3, 3) to (4t, 3, 3)."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
