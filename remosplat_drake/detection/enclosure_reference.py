"""Slow reference of `fit_box`, which fits one rounded box to points.

`fit_box` is in `kernels/fit_box.py`.
"""

import numpy as np

from remosplat_drake.detection.enclosure import RoundedBox


def fit(p_W: np.ndarray, padding: float) -> RoundedBox:
    """Fits the smaller of a box and a capsule, along the points' main axes.

    Args:
        p_W: At least one point in W, shape (n, 3) [m].
        padding: Margin on all sides [m].
    """
    centered = p_W - p_W.mean(axis=0)
    _, axes = np.linalg.eigh(centered.T @ centered)
    if np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    p_M = p_W @ axes
    lower, upper = p_M.min(axis=0), p_M.max(axis=0)
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    box = RoundedBox(axes, axes @ middle, half, padding)
    capsule = _capsule(p_M - middle, axes, middle, padding)
    return min(box, capsule, key=lambda shape: shape.volume)


def _capsule(
    p_M: np.ndarray, axes: np.ndarray, middle: np.ndarray, padding: float
) -> RoundedBox:
    """Returns a capsule along the last axis, which has the greatest spread."""
    aside = np.hypot(p_M[:, 0], p_M[:, 1])
    radius = aside.max()
    caps = np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
    length = max(0.0, float((np.abs(p_M[:, 2]) - caps).max()))
    core = np.array([0, 0, length])
    return RoundedBox(axes, axes @ middle, core, radius + padding)
