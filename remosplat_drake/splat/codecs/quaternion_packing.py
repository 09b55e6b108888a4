"""Packs unit quaternions by the smallest-three method.

The component of largest magnitude is omitted, since it can be computed from the
three others, which are in [-1/sqrt(2), 1/sqrt(2)]. All packed formats of splats
use this method. They differ in the order of the components and in the rounding.
"""

import numpy as np


def smallest_three(unit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Splits unit quaternions into their largest component and the other three.

    Args:
        unit: Unit quaternions of any component order, shape (N, 4).

    Returns:
        The index of the largest component, shape (N,), and the three other
        components in their order, shape (N, 3). The sign of the quaternion is
        chosen such that the largest component is positive.
    """
    n = len(unit)
    largest = np.abs(unit).argmax(axis=1)
    sign = np.where(unit[np.arange(n), largest] < 0, -1.0, 1.0)
    others = np.arange(4) != largest[:, None]
    return largest, unit[others].reshape(n, 3) * sign[:, None]


def from_smallest_three(largest: np.ndarray, three: np.ndarray) -> np.ndarray:
    """Restores unit quaternions (N, 4) from the result of `smallest_three`."""
    unit = np.empty((len(three), 4))
    others = np.arange(4) != largest[:, None]
    unit[others] = np.ravel(three)
    missing = 1 - np.sum(np.square(three), axis=1)
    unit[~others] = np.sqrt(np.maximum(missing, 0))
    return unit


def rounded(values: np.ndarray, largest: int) -> np.ndarray:
    """Rounds values to the integers from 0 to `largest`, as uint32."""
    return np.clip(np.rint(values), 0, largest).astype(np.uint32)
