"""Numbers as a report shows them: with counts and 95 % intervals."""

import math

import numpy as np

from remosplat_drake.benchmark.statistics import mean_interval, wilson_interval


def format_rate(successes: int, count: int) -> str:
    """A rate in per cent, its interval and its counts."""
    if not count:
        return "–"
    low, high = wilson_interval(successes, count)
    return (
        f"{100 * successes / count:.1f} [{100 * low:.1f}, {100 * high:.1f}]"
        f" ({successes}/{count})"
    )


def format_rare(successes: int, count: int) -> str:
    """Counts of what should not happen, and the upper bound of its rate."""
    _, high = wilson_interval(successes, count)
    return f"{successes}/{count} (< {100 * high:.1f} %)"


def format_mean(values: np.ndarray, decimals: int) -> str:
    """A mean and half the width of its interval."""
    if not len(values):
        return "–"
    mean, half = mean_interval(values)
    if math.isnan(half):
        return f"{mean:.{decimals}f}"
    return f"{mean:.{decimals}f} ± {half:.{decimals}f}"


def format_median(values: np.ndarray, decimals: int) -> str:
    """A median; a dash without values."""
    return f"{np.median(values):.{decimals}f}" if len(values) else "–"
