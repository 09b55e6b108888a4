"""Every case of `remosplat bench` can be timed: each of each group."""

import dataclasses as dc

import pytest

from remosplat_drake.commands.bench import GROUPS
from remosplat_drake.timing.measuring import measure

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
