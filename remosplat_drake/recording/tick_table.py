"""`TickTable`: the ticks of a run as columns of numbers."""

from array import array
from collections import deque
from itertools import chain

import numpy as np

from remosplat_drake.recording.packed_movers import (
    MOVER,
    PackedMovers,
    PackedTicks,
    from_columns,
    to_columns,
)
from remosplat_drake.recording.tick_blocks import TickBlocks
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.tick_report import STATUSES, TickReport

BLOCK = 4000
"""Number of ticks that are written to disk together: 40 s at 100 Hz, or 1
MB."""

_TIMING = "timing_"
"""Prefix of the columns with the times of a tick's phases."""


class TickTable:
    """Stores the numbers of each `TickReport` that metrics need.

    A tick takes about 250 bytes, and each mover in a new message 208 bytes. The
    whole report, with all clearances, would take about a hundred times as much,
    and is not stored. If `block` is given, the table keeps the latest ticks in
    memory and all other ticks in a file.

    Attributes:
        trouble: Reason why ticks are missing; empty if none are missing.
    """

    def __init__(self, n_q: int, n_u: int, *, block: int | None = None):
        """Makes a table without ticks.

        Args:
            n_q: Length of the configuration.
            n_u: Length of the command.
            block: Number of ticks that are moved from memory to disk together.
                If it is None, all ticks remain in memory.
        """
        self._n_q, self._n_u = n_q, n_u
        self._block, self._blocks = block, TickBlocks()
        self._counts: list[int] = []
        self._lost = 0
        self.trouble = ""
        self._heard: Movers | None = None
        self._clear()

    def _clear(self) -> None:
        """Removes all ticks from memory."""
        self._time, self._q, self._u = array("d"), array("d"), array("d")
        self._status = array("B")
        self._scale, self._clearance = array("d"), array("d")
        self._line_deviation, self._margin = array("d"), array("d")
        self._timings: dict[str, array] = {}
        self._movers: deque[PackedMovers] = deque()

    def __len__(self) -> int:
        return sum(self._counts) + len(self._time)

    @property
    def line_deviation(self) -> np.ndarray:
        """`TickReport.line_deviation` of the T ticks, shape (T,) [m]."""
        return self._whole("line_deviation")

    @property
    def separation_margin(self) -> np.ndarray:
        """`Separation.margin` of the T ticks, shape (T,) [m]; NaN for none."""
        return self._whole("margin")

    def append(
        self,
        report: TickReport,
        executed: np.ndarray,
        movers: Movers | None = None,
    ) -> None:
        """Adds a tick.

        Args:
            report: The controller's report.
            executed: The command after the supervisor, shape (n_u,).
            movers: The movers at the tick; None in a run without movers.
        """
        separation = report.separation
        margin = np.nan if separation is None else separation.margin
        self._add_timings(report.timings)
        self._time.append(report.time)
        self._q.frombytes(np.asarray(report.q, float).tobytes())
        self._u.frombytes(np.asarray(executed, float).tobytes())
        self._status.append(STATUSES.index(report.status))
        self._scale.append(report.scale)
        self._clearance.append(report.clearances.minimum())
        self._line_deviation.append(report.line_deviation)
        self._margin.append(margin)
        if movers is not None:
            # On a real robot, several ticks share a message about movers.
            is_new = movers is not self._heard or not self._movers
            self._heard = movers
            self._movers.append(
                PackedMovers.of(movers) if is_new else self._movers[-1]
            )
        if self._block is not None and len(self._time) >= self._block:
            self._put_block_away()

    def _add_timings(self, timings: dict[str, float]) -> None:
        """Adds the times of a tick's phases; NaN for a missing phase."""
        for phase in timings.keys() - self._timings.keys():
            self._timings[phase] = array("d", [np.nan]) * len(self._time)
        for phase, column in self._timings.items():
            column.append(timings.get(phase, np.nan))

    def _put_block_away(self) -> None:
        """Moves ticks from memory to disk; drops them if the disk is full."""
        count, problem = len(self._time), self._blocks.append(self._columns())
        if problem:
            self._lost += count
            self.trouble = f"the trajectory lacks {self._lost} ticks: {problem}"
        else:
            self._counts.append(count)
        self._clear()

    def forget_before(self, time: float) -> None:
        """Removes the oldest ticks from memory.

        Args:
            time: Time before which ticks are removed [s].
        """
        count = 0
        while count < len(self._time) and self._time[count] < time:
            count += 1
        if not count:
            return
        del self._q[: count * self._n_q]
        del self._u[: count * self._n_u]
        for column in (
            self._time,
            self._status,
            self._scale,
            self._clearance,
            self._line_deviation,
            self._margin,
            *self._timings.values(),
        ):
            del column[:count]
        for _ in range(count if self._movers else 0):
            self._movers.popleft()

    def trajectory(self, q_end: np.ndarray) -> Trajectory:
        """Returns the ticks as a trajectory.

        Args:
            q_end: Configuration after the last tick, shape (n_q,).

        Raises:
            OSError: The data on the disk cannot be read.
        """
        phases = sorted(
            name.removeprefix(_TIMING)
            for name in {*self._blocks.names, *self._columns()}
            if name.startswith(_TIMING)
        )
        status = self._whole("status")
        present = np.unique(status)
        # So NumPy makes the strings only as long as the longest status in this
        # run.
        names = np.array([STATUSES[i] for i in present], dtype=str)
        movers = self._all_movers()
        return Trajectory(
            time=self._whole("time"),
            q=np.vstack([self._whole("q"), q_end]),
            u=self._whole("u"),
            status=names[np.searchsorted(present, status)],
            scale=self._whole("scale"),
            clearance=self._whole("clearance"),
            timings={p: self._whole(_TIMING + p) for p in phases},
            movers=PackedTicks(movers) if movers else (),
        )

    def _columns(self) -> dict[str, np.ndarray]:
        """Returns the ticks in memory as arrays, keyed by name."""
        timings = {_TIMING + k: np.array(v) for k, v in self._timings.items()}
        return {
            "time": np.array(self._time),
            "q": np.array(self._q).reshape(-1, self._n_q),
            "u": np.array(self._u).reshape(-1, self._n_u),
            "status": np.array(self._status),
            "scale": np.array(self._scale),
            "clearance": np.array(self._clearance),
            "line_deviation": np.array(self._line_deviation),
            "margin": np.array(self._margin),
            **timings,
            **to_columns(self._movers),
        }

    def _whole(self, name: str) -> np.ndarray:
        """Returns a column of all ticks; NaN for blocks without this column."""
        blocks = [*self._blocks.read(name), self._columns()]
        counts = [*self._counts, len(self._time)]
        return np.concatenate(
            [
                block.get(name, np.full(count, np.nan))
                for block, count in zip(blocks, counts, strict=True)
            ]
        )

    def _all_movers(self) -> list[PackedMovers]:
        there = chain.from_iterable(map(from_columns, self._blocks.read(MOVER)))
        return [*there, *self._movers]
