"""Worked by hand: the wrist of the three-link arm and its upper arm."""

import numpy as np

HOME = 2.3


def gap(elbow: float) -> float:
    """From the middle of the wrist to the upper arm's box.

    The box reaches 0.03 m to all sides of the upper arm and ends at the elbow,
    the wrist is 0.4 m from there.
    """
    ahead = max(0.4 * np.cos(elbow), 0.0)
    return float(np.hypot(ahead, max(0.4 * np.sin(elbow) - 0.03, 0.0)))
