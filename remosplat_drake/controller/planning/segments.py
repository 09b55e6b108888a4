"""Converts a path to segments on which the base only turns or only drives.

A search draws the heading of the base at each corner at random. If a turn is
necessary only to reach such a heading, it is omitted.
"""

from itertools import pairwise

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.steering import waypoints, wrapped


def driven_corners(space: FreeSpace, corners: np.ndarray) -> np.ndarray:
    """Returns all corners of a path, also those between a turn and a drive.

    Args:
        space: The free space.
        corners: Corners of a free path, shape (m, n_q) [rad, m].

    Returns:
        Corners of segments on which the base either only turns or only drives
        straight on, with unwrapped yaw, shape (k, n_q) [rad, m].
    """
    if not space.robot.n_base:
        return corners
    steps = [
        waypoints(a, b, space.robot.n_base, space.backing)
        for a, b in pairwise(corners)
    ]
    all_corners = [corners[0]]
    for step in steps:
        for corner in step[1:]:
            all_corners.append(_unwound(all_corners[-1], corner))
    return np.array(_without_spins(space, all_corners))


def _unwound(before: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Returns a corner with its yaw unwrapped relative to the previous one."""
    corner = corner.copy()
    corner[2] = before[2] + wrapped(corner[2] - before[2])
    return corner


def _without_spins(
    space: FreeSpace, corners: list[np.ndarray]
) -> list[np.ndarray]:
    """Omits corners between two consecutive turns of the base."""
    kept = [corners[0]]
    for corner in corners[1:]:
        corner = _unwound(kept[-1], corner)
        while len(kept) > 1 and _only_turns(kept[-2], kept[-1], corner):
            direct = _unwound(kept[-2], corner)
            if not space.is_free_between(kept[-2], direct):
                break
            kept.pop()
            corner = direct
        kept.append(corner)
    return kept


def _only_turns(*corners: np.ndarray) -> bool:
    """Returns whether the base only turns."""
    places = np.array(corners)[:, :2]
    return bool(np.abs(places - places[0]).max() < 1e-6)
