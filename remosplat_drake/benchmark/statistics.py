"""How sure the numbers of a benchmark are."""

import math

import numpy as np
from scipy.stats import binomtest

Z_95 = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution."""


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a rate (Wilson's score interval).

    It stays inside [0, 1] and means something at 0 and at `count`.
    """
    if count == 0:
        return 0.0, 1.0
    rate, z2 = successes / count, Z_95**2
    center = rate + z2 / (2 * count)
    spread = Z_95 * math.sqrt(
        rate * (1 - rate) / count + z2 / (4 * count * count)
    )
    scale = 1 + z2 / count
    low, high = (center - spread) / scale, (center + spread) / scale
    return max(low, 0.0), min(high, 1.0)


def mean_interval(values: np.ndarray) -> tuple[float, float]:
    """Mean and half the width of its 95 % interval, NaN without values."""
    if not len(values):
        return math.nan, math.nan
    if len(values) == 1:
        return float(values[0]), math.nan
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return float(np.mean(values)), Z_95 * error


def mcnemar(a: np.ndarray, b: np.ndarray) -> tuple[int, int, float]:
    """Exact test whether two methods succeed equally often on equal scenes.

    Args:
        a: Success of the one, shape (n,) bool.
        b: Success of the other, shape (n,) bool.

    Returns:
        How many scenes only a solved, only b solved, and the two-sided
        p-value.
    """
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    n = only_a + only_b
    p = float(binomtest(only_a, n).pvalue) if n else 1.0
    return only_a, only_b, p
