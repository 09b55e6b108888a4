"""Measures percentiles of the durations of many calls, after a warm-up."""

import dataclasses as dc
from collections.abc import Callable, Iterable
from itertools import cycle
from time import perf_counter
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


@dc.dataclass(frozen=True)
class Case:
    """A function whose duration is measured, with its name.

    Attributes:
        name: Name of the case in tables.
        function: Function without arguments.
        seconds: Approximate total duration of the repeated calls [s].
        checks: Function that returns the number of checks that a search made,
            given its result; None if the function is no search.
    """

    name: str
    function: Callable[[], Any]
    seconds: float = 1.0
    checks: Callable[[Any], int] | None = None


@dc.dataclass(frozen=True)
class Timing:
    """Statistics of the wall-clock times of a case's calls.

    Attributes:
        name: Name of the case.
        p50: Median [s].
        p95: 95th percentile [s].
        p99: 99th percentile [s].
        longest: Time of the slowest call [s].
        calls: Number of timed calls.
        checks: Median of the number of checks in a call; None if the calls make
            no checks.
        per_check: Median of the ratio of time and number of checks [s].
    """

    name: str
    p50: float
    p95: float
    p99: float
    longest: float
    calls: int
    checks: float | None = None
    per_check: float | None = None


def in_turn(
    inputs: Iterable[T], function: Callable[[T], object]
) -> Callable[[], object]:
    """Returns a function whose calls pass the inputs to another one in turn.

    Args:
        inputs: The inputs; after the last one, the first follows.
        function: The function that is measured.
    """
    again = cycle(inputs)
    return lambda: function(next(again))


def measure(case: Case, min_calls: int = 2) -> Timing:
    """Measures a case, after one call that compiles kernels and warms caches.

    Args:
        case: The function to time.
        min_calls: The function is called at least this many times.
    """
    case.function()
    durations: list[float] = []
    checks: list[int] = []
    end = perf_counter() + case.seconds
    while perf_counter() < end or len(durations) < min_calls:
        start = perf_counter()
        result = case.function()
        durations.append(perf_counter() - start)
        if case.checks is not None:
            checks.append(case.checks(result))
    p50, p95, p99 = np.percentile(durations, [50, 95, 99])
    timing = Timing(
        case.name,
        float(p50),
        float(p95),
        float(p99),
        max(durations),
        len(durations),
    )
    if not checks:
        return timing
    each = np.array(durations) / np.maximum(checks, 1)
    return dc.replace(
        timing,
        checks=float(np.median(checks)),
        per_check=float(np.median(each)),
    )
