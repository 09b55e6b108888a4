"""Measures the memory of a process, and its growth."""

import dataclasses as dc
from collections.abc import Sequence
from pathlib import Path

import numpy as np

_PAGES = ("RssAnon", "RssFile", "RssShmem")
_WARM_UP = 1 / 3
"""Initial fraction of the time that the trend ignores, since loading and
compiling on first use increase memory."""


@dc.dataclass(frozen=True)
class MemoryUse:
    """Resident memory of a process.

    Attributes:
        own: Memory of this process alone [MB].
        files: Mapped files and libraries, shared with others [MB].
    """

    own: float
    files: float


@dc.dataclass(frozen=True)
class MemoryTrend:
    """Trend of the resident memory of a process.

    Attributes:
        first: Memory at the end of the warm-up [MB].
        last: Memory at the end [MB].
        most: Largest memory at any time [MB].
        slope: Growth after the warm-up [MB/min].
        own_slope: Growth of the memory of this process alone [MB/min].
    """

    first: float
    last: float
    most: float
    slope: float
    own_slope: float


def memory_of(pid: int | str = "self") -> MemoryUse:
    """Reads the resident memory of a process.

    Raises:
        OSError: The process does not exist, or the system provides no data.
    """
    kilobytes = dict.fromkeys(_PAGES, 0.0)
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        name, _, value = line.partition(":")
        if name in kilobytes:
            kilobytes[name] = float(value.split()[0])
    own, files, shared = (kilobytes[name] / 1024 for name in _PAGES)
    return MemoryUse(own, files + shared)


def trend(minutes: Sequence[float], uses: Sequence[MemoryUse]) -> MemoryTrend:
    """Fits the least-squares trend after the first third of the time.

    Args:
        minutes: Times at which memory was sampled, ascending [min].
        uses: Memory at these times; at least two samples after the first
            third.
    """
    time = np.array(minutes)
    own = np.array([use.own for use in uses])
    total = own + np.array([use.files for use in uses])
    late = time >= time[0] + _WARM_UP * (time[-1] - time[0])
    return MemoryTrend(
        first=float(total[late][0]),
        last=float(total[-1]),
        most=float(total.max()),
        slope=float(np.polyfit(time[late], total[late], 1)[0]),
        own_slope=float(np.polyfit(time[late], own[late], 1)[0]),
    )
