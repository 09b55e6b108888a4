"""Time functions fairly: warmed up, many times, by percentiles."""

import dataclasses as dc
from collections.abc import Callable
from time import perf_counter

import numpy as np


@dc.dataclass(frozen=True)
class Case:
    """A function to be timed.

    Attributes:
        name: What the table calls it.
        function: Called without arguments; what it returns is dropped.
        seconds: Roughly how long to keep calling it.
    """

    name: str
    function: Callable[[], object]
    seconds: float = 1.0


@dc.dataclass(frozen=True)
class Timing:
    """Wall-clock seconds of a case.

    Attributes:
        name: The case.
        p50: Median.
        p95: 95th percentile.
        p99: 99th percentile.
        longest: The slowest call.
        calls: How many calls were timed.
    """

    name: str
    p50: float
    p95: float
    p99: float
    longest: float
    calls: int


def measure(case: Case, min_calls: int = 2) -> Timing:
    """Times a case after one call that compiles and warms the caches."""
    case.function()
    durations: list[float] = []
    end = perf_counter() + case.seconds
    while perf_counter() < end or len(durations) < min_calls:
        start = perf_counter()
        case.function()
        durations.append(perf_counter() - start)
    p50, p95, p99 = np.percentile(durations, [50, 95, 99])
    return Timing(
        case.name,
        float(p50),
        float(p95),
        float(p99),
        max(durations),
        len(durations),
    )
