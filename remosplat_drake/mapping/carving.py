"""Carving: finds the discs of a splat that belong to vanished objects."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_cells import THINNEST
from remosplat_drake.reconstruction.measured_space import times_looked_through

_APART = 0.03
"""A group of discs in free space is a vanished object only if one of them is at
least this far from all remaining discs [m]. Other discs in free space may be
edges about which views slightly disagree."""

_AROUND = 0.1
"""Other discs of a vanished object are searched for within this distance of
those of its discs that are in free space [m].
"""

_PAST = 0.01
"""A disc near a vanished object is removed, too, if a view measures a surface
at least this far behind the disc [m]."""

_NEIGHBORS = 8
_MOST = 0.6
"""A disc near a vanished object is removed, too, if at least this fraction of
its neighbours is removed. Such remnants are caused by irregular outlines of
depth images and by pixels without depth.
"""


def find_gone(p_WK: np.ndarray, capture: Capture) -> np.ndarray:
    """Finds the discs of vanished objects: views measure surfaces behind them.

    The result includes the lowest discs of an object, although the support that
    views measure is close behind them. For a thin object, only views with
    closely spaced pixels count, since all rays of other views may pass beside
    it.

    Args:
        p_WK: The discs' centres in W, shape (n, 3) [m].
        capture: Views of the present scene.

    Returns:
        A mask of the discs, shape (n,).
    """
    through = times_looked_through(capture, p_WK) > 0
    p_WG = p_WK[through].astype(float)
    seen = times_looked_through(capture, p_WG, pitch=_widths(p_WG)) > 0
    through[through] = seen
    if not through.any():
        return through
    core = through
    if not through.all():
        apart, _ = KDTree(p_WK[~through]).query(p_WK)
        core = through & (apart > _APART)
    return core | find_rest(p_WK, p_WK[core], capture)


def _widths(p_W: np.ndarray) -> np.ndarray:
    """Returns the width of objects at discs (n, 3), at least `THINNEST`, (n,).

    The width is twice the second largest standard deviation of the nearest
    discs' positions, because the largest one is along a rod. A strip is 1.7
    times as wide.
    """
    if len(p_W) <= _NEIGHBORS:
        return np.full(len(p_W), THINNEST)
    apart, near = KDTree(p_W).query(
        p_W, _NEIGHBORS + 1, distance_upper_bound=_AROUND
    )
    weight = np.isfinite(apart)[..., None]
    around = p_W[np.minimum(near, len(p_W) - 1)]
    total = weight.sum(axis=1, keepdims=True)
    mean = (weight * around).sum(axis=1, keepdims=True) / total
    offset = weight * (around - mean)
    covariance = np.einsum("nki,nkj->nij", offset, offset) / total
    variance = np.linalg.eigvalsh(covariance)[:, 1]
    return np.maximum(2 * np.sqrt(np.maximum(variance, 0)), THINNEST)


def find_rest(
    p_WK: np.ndarray, gone_W: np.ndarray, capture: Capture
) -> np.ndarray:
    """Finds the discs that must be removed together with vanished discs nearby.

    Args:
        p_WK: The discs' centres in W, shape (n, 3) [m].
        gone_W: Points of vanished objects in W, shape (m, 3) [m].
        capture: Views of the present scene.

    Returns:
        A mask of the discs, shape (n,).
    """
    rest = np.zeros(len(p_WK), bool)
    if not len(gone_W):
        return rest
    apart, _ = KDTree(gone_W).query(p_WK, distance_upper_bound=_AROUND)
    near = np.flatnonzero(np.isfinite(apart))
    past = times_looked_through(capture, p_WK[near], _PAST) > 0
    rest[near[past]] = True
    return rest | _specks(p_WK, near, rest)


def _specks(p_WK: np.ndarray, near: np.ndarray, gone: np.ndarray) -> np.ndarray:
    """Returns a mask of discs that are surrounded by removed discs."""
    specks = np.zeros(len(p_WK), bool)
    if len(p_WK) <= _NEIGHBORS:
        return specks
    # The first neighbour is the disc itself.
    _, index = KDTree(p_WK).query(p_WK[near], k=_NEIGHBORS + 1)
    specks[near] = gone[np.asarray(index)[:, 1:]].mean(axis=1) > _MOST
    return specks
