"""How much memory a process holds, and whether that grows."""

import dataclasses as dc
from collections.abc import Sequence
from pathlib import Path

import numpy as np

_PAGES = ("RssAnon", "RssFile", "RssShmem")
_WARM_UP = 1 / 3
"""What is loaded or compiled on first use makes the first part grow."""


@dc.dataclass(frozen=True)
class MemoryUse:
    """What a process has in memory.

    Attributes:
        own: What nobody else has [MB].
        files: Files and libraries that are mapped, shared with others [MB].
    """

    own: float
    files: float


@dc.dataclass(frozen=True)
class MemoryTrend:
    """How what a process has in memory changes.

    Attributes:
        first: At the end of the warm-up [MB].
        last: At the end [MB].
        most: At any time [MB].
        slope: After the warm-up [MB/min].
        own_slope: Of what nobody else has [MB/min].
    """

    first: float
    last: float
    most: float
    slope: float
    own_slope: float


def memory_of(pid: int | str = "self") -> MemoryUse:
    """What a process has in memory now.

    Raises:
        OSError: There is no such process, or the system does not tell.
    """
    kilobytes = dict.fromkeys(_PAGES, 0.0)
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        name, _, value = line.partition(":")
        if name in kilobytes:
            kilobytes[name] = float(value.split()[0])
    own, files, shared = (kilobytes[name] / 1024 for name in _PAGES)
    return MemoryUse(own, files + shared)


def trend(minutes: Sequence[float], uses: Sequence[MemoryUse]) -> MemoryTrend:
    """The least-squares trend after the first third of the time.

    Args:
        minutes: When memory was looked at, ascending [min].
        uses: What was found then; at least two after the first third.
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
