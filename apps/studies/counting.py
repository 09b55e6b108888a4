"""Confidence intervals of shares and of probabilities."""

import numpy as np
from scipy.stats import binomtest

_RESAMPLES = 2000


def share_with_interval(
    counts: np.ndarray, seed: int = 0
) -> tuple[float, float, float]:
    """Computes a share of items, with a confidence interval over their groups.

    Items of one group are correlated, so groups are resampled (a bootstrap),
    not items.

    Args:
        counts: Number of counted items of each group, and its number of items,
            shape (n, 2).
        seed: Seed of the bootstrap.

    Returns:
        The share of all items, and the bounds of its 95 % interval.
    """
    rng = np.random.default_rng(seed)
    drawn = rng.integers(len(counts), size=(_RESAMPLES, len(counts)))
    sums = counts[drawn].sum(axis=1)
    low, high = np.percentile(sums[:, 0] / sums[:, 1], [2.5, 97.5])
    kept, total = counts.sum(axis=0)
    return float(kept / total), float(low), float(high)


def upper_limit(count: int, total: int) -> float:
    """Returns the upper bound of a probability's 95 % interval.

    The interval is the two-sided one of Clopper and Pearson.

    Args:
        count: Number of events.
        total: Number of trials, at least 1.
    """
    interval = binomtest(count, total).proportion_ci(0.95, "exact")
    return float(interval.high)
