"""Finds groups of views that share surfaces, and connections between groups."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.findings import (
    ONE_JOINT,
    SEPARATE,
    WARNING,
    Finding,
    list_frames,
)
from remosplat_drake.capture.checks.overlap import (
    sample_points,
    shared_fractions,
)
from remosplat_drake.capture.checks.wide_baselines import share_surfaces

_GROUP, _PART = 5, 0.2
"""A group has at least this many frames (first number), and at least this
fraction of all frames that share surfaces with others (second number).
"""

_COARSE, _MIN_SHARED = 40, 0.1
"""This many points of a view are projected into the images of other views
(first number). Two views are compared only if at least this fraction of the
points is inside the image (second number)."""

_TRIED = 60
"""To join two groups, at most this many pairs of views are compared."""


def judge_groups(capture: Capture, pairs: np.ndarray) -> list[Finding]:
    """Judges whether shared surfaces connect all views redundantly.

    Args:
        capture: The capture of n views.
        pairs: Indices of views that share surfaces, shape (m, 2); some pairs
            may be missing.
    """
    n = len(capture)
    pairs = _joined(capture, pairs, np.zeros(0, int))
    groups = view_groups(pairs, n)
    if len(groups) > 1:
        problem = (
            f"{len(groups)} groups of frames share no surface, so their "
            "relative poses are unchecked; they begin with "
            f"{list_frames([int(g[0]) for g in groups], capture)}"
        )
        return [Finding(SEPARATE, problem, WARNING)]
    joints = []
    for view in np.unique(pairs).tolist():
        rest = pairs[(pairs != view).all(axis=1)]
        if len(view_groups(rest, n)) < 2:
            continue
        rest = _joined(capture, rest, np.array([view]))
        if len(view_groups(rest, n)) > 1:
            joints.append(view)
    if not joints:
        return []
    problem = (
        "single frames connect parts of the capture, so a pose error of such "
        f"a frame displaces a whole part: {list_frames(joints, capture)}"
    )
    return [Finding(ONE_JOINT, problem, WARNING, frames=tuple(joints))]


def view_groups(pairs: np.ndarray, n: int) -> list[np.ndarray]:
    """Finds the groups of views that shared surfaces connect.

    Args:
        pairs: Indices of views that share surfaces, shape (m, 2).
        n: Number of views.

    Returns:
        Indices of each group's views, ascending, the largest group first. Small
        groups are omitted.
    """
    graph = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    connected = np.isin(np.arange(n), pairs)
    least = max(_GROUP, _PART * connected.sum())
    groups = [
        np.flatnonzero(connected & (label == name))
        for name in np.unique(label[connected])
    ]
    groups = [group for group in groups if len(group) >= least]
    return sorted(groups, key=len, reverse=True)


def _joined(
    capture: Capture, pairs: np.ndarray, without: np.ndarray
) -> np.ndarray:
    """Adds a pair of views between any two groups that share surfaces.

    Args:
        capture: The views.
        pairs: Indices of views that share surfaces, shape (m, 2).
        without: Indices of views whose shared surfaces are ignored.
    """
    groups = view_groups(pairs, len(capture))
    if len(groups) < 2:
        return pairs
    p_C = sample_points(capture, _COARSE, np.random.default_rng(0))
    shared = shared_fractions(capture, p_C)
    shared[without] = shared[:, without] = 0
    for other in groups[1:]:
        one, rest = groups[0], np.ix_(groups[0], other)
        order = np.argsort(-shared[rest], axis=None)[:_TRIED]
        rows, columns = np.unravel_index(order, shared[rest].shape)
        for a, b in zip(
            one[rows].tolist(), other[columns].tolist(), strict=True
        ):
            if shared[a, b] < _MIN_SHARED:
                break
            if share_surfaces(capture, a, b):
                pairs = np.concatenate([pairs, [[a, b]]])
                break
    return pairs
