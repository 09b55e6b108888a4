"""Intervals of the studies' counts, by hand."""

import numpy as np
import pytest

from apps.studies.counting import share_with_interval, upper_limit


def test_the_upper_limit_is_that_of_clopper_and_pearson():
    # Of ten cases none: the probability p with (1 - p)^10 = 2.5 %.
    assert upper_limit(0, 10) == pytest.approx(1 - 0.025**0.1)
    assert upper_limit(10, 10) == 1
    # Of two cases one: that of at most one, 1 - p^2, is 2.5 %.
    assert upper_limit(1, 2) == pytest.approx(np.sqrt(0.975))


def test_a_share_is_as_sure_as_its_groups_agree():
    alike = np.tile([90, 100], (20, 1))
    assert share_with_interval(alike) == (0.9, 0.9, 0.9)
    apart = np.repeat([[100, 100], [80, 100]], 10, axis=0)
    share, low, high = share_with_interval(apart)
    # The mean of 20 draws of 0.8 or 1 has a standard deviation of 0.0224.
    assert share == 0.9
    assert low == pytest.approx(0.9 - 1.96 * 0.0224, abs=0.006)
    assert high == pytest.approx(0.9 + 1.96 * 0.0224, abs=0.006)
