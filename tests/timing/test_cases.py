"""Every case of `remosplat bench` can be timed: each of each group."""

import dataclasses as dc

import pytest

from remosplat_drake.commands.bench import GROUPS
from remosplat_drake.timing.measuring import Case, measure

LONG = {"depth", "files", "objects", "oracle", "planning", "solvers"}
"""Groups whose scenes or programs take seconds to make."""


@pytest.mark.parametrize(
    "group",
    [
        pytest.param(group, marks=[pytest.mark.slow] * (group in LONG))
        for group in GROUPS
    ],
)
def test_every_case_of_a_group_runs(group):
    cases = GROUPS[group]()
    names = [case.name for case in cases]
    assert len(set(names)) == len(names) > 0  # `--compare` goes by names.
    for case in cases:
        timing = measure(dc.replace(case, seconds=0.0))
        assert timing.calls == 2, case.name
        assert 0.0 < timing.p50 <= timing.p99 <= timing.longest, case.name
        assert (timing.checks is None) == (case.checks is None), case.name


def test_the_time_of_a_check_is_that_of_a_call_by_its_number_of_checks():
    numbers = iter([1, 4, 4, 4])
    case = Case("search", lambda: next(numbers), 0.0, checks=lambda n: n)
    timing = measure(case, min_calls=3)
    assert timing.checks == 4.0
    assert timing.per_check == pytest.approx(timing.p50 / 4)
    assert measure(Case("no search", int, 0.0)).per_check is None
