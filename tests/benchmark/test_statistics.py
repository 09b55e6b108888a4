"""Intervals and tests, against published and hand-worked numbers."""

import numpy as np
import pytest

from remosplat_drake.benchmark.statistics import (
    mcnemar,
    mean_interval,
    wilson_interval,
)


@pytest.mark.parametrize(
    ("successes", "count", "low", "high"),
    [
        (997, 1000, 0.991, 0.999),
        (841, 1000, 0.817, 0.862),
        (0, 10, 0.0, 0.278),
        (10, 10, 0.722, 1.0),
        (0, 0, 0.0, 1.0),
    ],
)
def test_wilson_interval(successes, count, low, high):
    interval = wilson_interval(successes, count)
    assert interval == pytest.approx((low, high), abs=5e-4)


def test_mean_interval():
    mean, half = mean_interval(np.array([1.0, 2.0, 3.0, 4.0]))
    # The standard deviation is sqrt(5/3).
    assert mean == 2.5
    assert half == pytest.approx(1.96 * np.sqrt(5 / 3) / 2, rel=1e-4)
    assert np.isnan(mean_interval(np.zeros(0))[0])
    assert np.isnan(mean_interval(np.ones(1))[1])


def test_mcnemar_counts_only_where_two_methods_differ():
    a = np.array([1, 1, 1, 1, 1, 1, 0], bool)
    b = np.array([1, 0, 0, 0, 0, 0, 0], bool)
    # Five tosses that all fall on one side: 2 / 2^5.
    assert mcnemar(a, b) == (5, 0, pytest.approx(0.0625))
    assert mcnemar(a, a) == (0, 0, 1.0)
