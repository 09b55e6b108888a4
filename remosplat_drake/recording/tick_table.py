"""`TickTable`: the ticks of a run as columns of numbers."""

from array import array
from collections import deque

import numpy as np

from remosplat_drake.recording.packed_movers import PackedMovers, PackedTicks
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.tick_report import STATUSES, TickReport


class TickTable:
    """Stores the numbers of each `TickReport` that metrics need.

    A tick takes about 250 bytes here, and each mover of a new message 208.
    The report, with all clearances, takes a hundred times as much and is not
    kept.
    """

    def __init__(self, n_q: int, n_u: int):
        """Makes a table without ticks.

        Args:
            n_q: Length of the configuration.
            n_u: Length of the command.
        """
        self._n_q, self._n_u = n_q, n_u
        self._time, self._q, self._u = array("d"), array("d"), array("d")
        self._status = array("B")
        self._scale, self._clearance = array("d"), array("d")
        self._line_deviation, self._margin = array("d"), array("d")
        self._timings: dict[str, array] = {}
        self._movers: deque[PackedMovers] = deque()
        self._heard: Movers | None = None

    def __len__(self) -> int:
        return len(self._time)

    @property
    def line_deviation(self) -> np.ndarray:
        """`TickReport.line_deviation` of the T ticks, shape (T,) [m]."""
        return np.array(self._line_deviation)

    @property
    def separation_margin(self) -> np.ndarray:
        """`Separation.margin` of the T ticks, shape (T,) [m]; NaN for none."""
        return np.array(self._margin)

    def append(
        self,
        report: TickReport,
        executed: np.ndarray,
        movers: Movers | None = None,
    ) -> None:
        """Adds a tick.

        Args:
            report: The controller's report.
            executed: The command as a supervisor let it pass, shape (n_u,).
            movers: The movers; None at all ticks of a run without movers.
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
            # Messages about them come less often than a real robot ticks.
            is_new = movers is not self._heard or not self._movers
            self._heard = movers
            self._movers.append(
                PackedMovers.of(movers) if is_new else self._movers[-1]
            )

    def _add_timings(self, timings: dict[str, float]) -> None:
        """Adds the times of a tick's phases; NaN for those it did not have."""
        for phase in timings.keys() - self._timings.keys():
            self._timings[phase] = array("d", [np.nan]) * len(self)
        for phase, column in self._timings.items():
            column.append(timings.get(phase, np.nan))

    def forget_before(self, time: float) -> None:
        """Removes the oldest ticks.

        Args:
            time: Time of the first tick that is kept, or any before [s].
        """
        count = 0
        while count < len(self) and self._time[count] < time:
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
        """
        q = np.array(self._q).reshape(-1, self._n_q)
        timings = {
            phase: np.array(self._timings[phase])
            for phase in sorted(self._timings)
        }
        return Trajectory(
            time=np.array(self._time),
            q=np.vstack([q, q_end]),
            u=np.array(self._u).reshape(-1, self._n_u),
            status=np.array([STATUSES[i] for i in self._status], dtype=str),
            scale=np.array(self._scale),
            clearance=np.array(self._clearance),
            timings=timings,
            movers=PackedTicks(self._movers) if self._movers else (),
        )
