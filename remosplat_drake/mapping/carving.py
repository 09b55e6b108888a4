"""Which discs of a splat belong to things that have gone."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through

_APART = 0.03
"""Of a thing that has gone, some part is farther than this from all that is
still there; edges that views disagree about a little are not [m]."""

_AROUND = 0.1
"""Of a thing that has gone, the rest is within this [m]."""

_PAST = 0.01
"""There, views need to see only so far past a disc for it to go too [m]."""

_NEIGHBORS = 8
_MOST = 0.6
"""A disc goes with this fraction of its neighbours, if nobody looks at it:
frayed outlines and pixels without depth leave such specks."""


def find_gone(p_WK: np.ndarray, capture: Capture) -> np.ndarray:
    """Discs of things that views have looked through, (n,) bool.

    The foot of a thing goes with it: it is near to what it stood on, so that
    views look past it by little.

    Args:
        p_WK: The discs' centres, shape (n, 3) [m].
        capture: What there is now.
    """
    through = times_looked_through(capture, p_WK) > 0
    if not through.any():
        return through
    core = through
    if not through.all():
        apart, _ = KDTree(p_WK[~through]).query(p_WK)
        core = through & (apart > _APART)
    return core | find_rest(p_WK, p_WK[core], capture)


def find_rest(
    p_WK: np.ndarray, gone_W: np.ndarray, capture: Capture
) -> np.ndarray:
    """Discs around what has gone that go with it, (n,) bool.

    Args:
        p_WK: The discs' centres, shape (n, 3) [m].
        gone_W: Points of what has gone, shape (m, 3) [m].
        capture: What there is now.
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
    """Discs among those near that are left over between gone ones."""
    specks = np.zeros(len(p_WK), bool)
    if len(p_WK) <= _NEIGHBORS:
        return specks
    # The first neighbour is the disc itself.
    _, index = KDTree(p_WK).query(p_WK[near], k=_NEIGHBORS + 1)
    specks[near] = gone[np.asarray(index)[:, 1:]].mean(axis=1) > _MOST
    return specks
