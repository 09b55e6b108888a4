"""Formats the numbers in a report's cells: rates, means and medians."""

import numpy as np
from scipy.stats import binomtest, norm, sem


def rate_interval(successes: int, count: int) -> tuple[float, float]:
    """Returns the 95 % interval of a rate (Wilson's score interval).

    The interval lies in [0, 1], and is valid even if no trial or every trial
    succeeded.
    """
    interval = binomtest(successes, count).proportion_ci(method="wilson")
    return interval.low, interval.high


def format_rate(successes: int, count: int) -> str:
    """Formats a rate in per cent, its 95 % interval and its counts."""
    if not count:
        return "–"
    low, high = rate_interval(successes, count)
    return (
        f"{100 * successes / count:.1f} [{100 * low:.1f}, {100 * high:.1f}]"
        f" ({successes}/{count})"
    )


def format_rare(successes: int, count: int) -> str:
    """Formats the count of a rare event, and the upper bound of its rate."""
    _, high = rate_interval(successes, count)
    return f"{successes}/{count} (< {100 * high:.1f} %)"


def format_mean(values: np.ndarray, decimals: int) -> str:
    """Formats a mean and half the width of its 95 % interval.

    Without values, the text is a dash. A single value has no interval.
    """
    if not len(values):
        return "–"
    mean = f"{np.mean(values):.{decimals}f}"
    if len(values) == 1:
        return mean
    return f"{mean} ± {norm.ppf(0.975) * sem(values):.{decimals}f}"


def format_median(values: np.ndarray, decimals: int) -> str:
    """Formats a median; without values, the text is a dash."""
    return f"{np.median(values):.{decimals}f}" if len(values) else "–"
