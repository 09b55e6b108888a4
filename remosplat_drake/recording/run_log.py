"""The log of a run: one row a control tick, written while it goes on.

A log is a line of JSON that says what is in it, and then rows of numbers of
`row_type`, one after the other. Nothing at its end says that it is complete,
so that a run that died in the middle has left a log like any other.
"""

import dataclasses as dc
import json
import math
from pathlib import Path

import numpy as np

from remosplat_drake.base.append_file import AppendFile
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_json import (
    as_number,
    as_whole_number,
    parse_json_object,
    shown,
)
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
)
from remosplat_drake.signals.tick_report import STATUSES, TickReport

FORMAT = "remosplat run log"
VERSION = 1

MODES = ("", STARTING, RUNNING, STOPPING, STOPPED)
"""Modes of the supervisor; the first stands for a run without one."""

NO_MAP = -1
"""Version of the map in a run whose map does not change."""

_HELD = 1.0
"""Rows of so much time are written together [s]."""

_HEADER_LIMIT = 4096
"""No header is longer [bytes]."""

_MAX_JOINTS = 1000


def row_type(n_q: int, n_u: int) -> np.dtype:
    """What a row holds; every number at a multiple of its size.

    time [s] and q of the tick; u as commanded by the controller, and as
    executed; the target X_WT without its last row; the smallest clearance by
    the oracle, inf beyond its influence [m]; verification's scale; version of
    the map; indices into `STATUSES` and `MODES`.
    """
    return np.dtype(
        [
            ("time", "<f8"),
            ("q", "<f8", (n_q,)),
            ("u_commanded", "<f8", (n_u,)),
            ("u_executed", "<f8", (n_u,)),
            ("X_WT", "<f8", (3, 4)),
            ("clearance", "<f8"),
            ("scale", "<f8"),
            ("map_version", "<i4"),
            ("status", "<u2"),
            ("mode", "<u2"),
        ]
    )


class RunLogWriter:
    """Writes a log; at most a second of rows waits in memory.

    Where the disk is full, rows are left out and `trouble` says so; once
    there is space again, the log goes on.

    Args:
        path: The log; must not exist.
        n_q: Size of the configuration.
        n_u: Size of the command.
        period: Control period [s].

    Attributes:
        trouble: Why rows are missing; empty while none is.

    Raises:
        FileError: The log cannot be begun.
    """

    def __init__(self, path: Path, *, n_q: int, n_u: int, period: float):
        header = {
            "format": FORMAT,
            "version": VERSION,
            "n_q": n_q,
            "n_u": n_u,
            "period": period,
            "statuses": STATUSES,
            "modes": MODES,
        }
        self.trouble = ""
        self._file = AppendFile(path, json.dumps(header).encode() + b"\n")
        size = max(1, math.ceil(_HELD / period))
        self._rows = np.zeros(size, row_type(n_q, n_u))
        # One view a column is quicker than one row at a time.
        names = self._rows.dtype.names or ()
        self._column = {name: self._rows[name] for name in names}
        self._count = 0
        self._lost = 0

    def append(
        self,
        report: TickReport,
        executed: np.ndarray,
        *,
        mode: str = "",
        map_version: int = NO_MAP,
    ) -> None:
        """Adds a tick.

        Args:
            report: The controller's.
            executed: Command as the robot got it, shape (n_u,).
            mode: The supervisor's.
            map_version: Of the map that the tick asked.
        """
        column, i = self._column, self._count
        column["time"][i] = report.time
        column["q"][i] = report.q
        column["u_commanded"][i] = report.command
        column["u_executed"][i] = executed
        column["X_WT"][i] = report.X_WT[:3]
        column["clearance"][i] = report.clearances.minimum()
        column["scale"][i] = report.scale
        column["map_version"][i] = map_version
        column["status"][i] = STATUSES.index(report.status)
        column["mode"][i] = MODES.index(mode)
        self._count += 1
        if self._count == len(self._rows):
            self.flush()

    def flush(self) -> None:
        """Hands the rows that wait to the operating system."""
        rows, self._count = self._rows[: self._count], 0
        problem = self._file.append(rows.tobytes())
        if problem:
            self._lost += len(rows)
            self.trouble = (
                f"{self._file.path.name} lacks {self._lost} ticks: {problem}"
            )

    def close(self) -> None:
        """Writes what waits, and closes the log."""
        self.flush()
        self._file.close()


@dc.dataclass(frozen=True, eq=False)
class RunLog:
    """A log that was read.

    Attributes:
        period: Control period [s].
        statuses: Names of the codes in the rows' `status`.
        modes: Names of the codes in the rows' `mode`.
        rows: T ticks of `row_type`, shape (T,).
    """

    period: float
    statuses: tuple[str, ...]
    modes: tuple[str, ...]
    rows: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)

    def between(self, start: float, end: float) -> "RunLog":
        """The ticks from `start` up to and including `end` [s]."""
        first = np.searchsorted(self.rows["time"], start, "left")
        last = np.searchsorted(self.rows["time"], end, "right")
        return dc.replace(self, rows=self.rows[first:last])

    def report(
        self, k: int, clearances: Clearances | None = None
    ) -> TickReport:
        """What the controller reported at tick k, as far as it was logged.

        Args:
            k: Index of the row.
            clearances: Stand in place of those of the tick, of which only
                the smallest was logged; their rows that are closest count as
                tight.
        """
        row = self.rows[k]
        clearances = Clearances.none() if clearances is None else clearances
        closest = clearances.distance == clearances.minimum()
        return TickReport(
            time=float(row["time"]),
            q=row["q"],
            command=row["u_commanded"],
            status=self.statuses[row["status"]],
            reason="",
            scale=float(row["scale"]),
            clearances=clearances,
            kept=np.zeros(len(clearances), bool),
            tight=closest,
            X_WT=np.vstack([row["X_WT"], [0.0, 0.0, 0.0, 1.0]]),
        )


@reads_file
def read_log(path: Path) -> RunLog:
    """Reads a log; a row that was cut off at its end is left out.

    Raises:
        FileError: The file cannot be read, or is no such log.
        FieldError: A field of its header is unusable; names it.
    """
    try:
        with open(path, "rb") as file:
            header = _read_header(path, file.readline(_HEADER_LIMIT))
            dtype = row_type(
                as_whole_number(path, "n_q", header.get("n_q"), 1, _MAX_JOINTS),
                as_whole_number(path, "n_u", header.get("n_u"), 1, _MAX_JOINTS),
            )
            count = (path.stat().st_size - file.tell()) // dtype.itemsize
            log = RunLog(
                _period(path, header),
                _names(path, header, "statuses"),
                _names(path, header, "modes"),
                np.fromfile(file, dtype, count),
            )
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    _check_rows(path, log)
    return log


def _read_header(path: Path, line: bytes) -> dict:
    try:
        header = parse_json_object(line, path)
    except FileError as error:
        raise FileError(path, "is not the log of a run") from error
    if header.get("format") != FORMAT:
        raise FileError(path, "is not the log of a run")
    if header.get("version") != VERSION:
        version = shown(header.get("version"))
        raise FileError(
            path, f"is a log of version {version}; valid: {VERSION}"
        )
    return header


def _period(path: Path, header: dict) -> float:
    period = as_number(path, "period", header.get("period"))
    if period <= 0:
        raise FieldError(str(path), "period", "must be positive")
    return period


def _names(path: Path, header: dict, field: str) -> tuple[str, ...]:
    names = header.get(field)
    if not isinstance(names, list) or not all(
        isinstance(name, str) for name in names
    ):
        raise FieldError(
            str(path), field, f"expected a list of names, got {shown(names)}"
        )
    return tuple(names)


def _check_rows(path: Path, log: RunLog) -> None:
    """Refuses rows that no run can have written."""
    good = {
        "time": np.isfinite(log.rows["time"]),
        "q": np.isfinite(log.rows["q"]).all(axis=1),
        "status": log.rows["status"] < len(log.statuses),
        "mode": log.rows["mode"] < len(log.modes),
    }
    for field, is_good in good.items():
        if not is_good.all():
            row = int(is_good.argmin())
            raise FileError(path, f"row {row}: {field} is damaged")
