"""Writes and reads the log of a run, which has a row for each control tick.

A log begins with a line of JSON that describes it. Consecutive rows of numbers
of the type `row_type` follow. A log has no end marker, so the log of a crashed
run is valid, too.
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
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
)
from remosplat_drake.signals.tick_report import STATUSES, TickReport

FORMAT = "remosplat run log"
"""Name of the format in the header of a log."""

VERSION = 1
"""Version of the format that this program writes and reads."""

MODES = ("", STARTING, RUNNING, STOPPING, STOPPED)
"""Modes of the supervisor. The log contains the index of the mode. The first
mode means that there is no supervisor."""

NO_MAP = -1
"""Version of the map in the rows of a run whose map does not change."""

_HELD = 1.0
"""Rows are written in blocks; a block contains the rows of this time [s]."""

_HEADER_LIMIT = 4096
"""Greatest accepted length of a header [bytes]."""

_MAX_JOINTS = 1000


def row_type(n_q: int, n_u: int) -> np.dtype:
    """Returns the NumPy type of a row, which has no padding.

    A row contains the time [s] and the configuration q of the tick; the
    controller's command u and the executed command; the first three rows of the
    matrix of the target X_WT; the smallest clearance by the distance oracle
    [m], which is inf beyond the influence distance; the scale of the command
    after verification; the version of the map; and the indices of the status in
    `STATUSES` and of the mode in `MODES`.

    Args:
        n_q: Length of the configuration.
        n_u: Length of the command.
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
    """Writes a log; rows are passed to the operating system once per second.

    If the disk is full, rows are dropped, and `trouble` states this. The log
    continues when there is space again.

    Args:
        path: The file; it must not exist.
        n_q: Length of the configuration.
        n_u: Length of the command.
        period: Control period [s].

    Attributes:
        trouble: Reason why rows are missing in the file; empty if the file is
            complete.

    Raises:
        FileError: The file exists or cannot be made.
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
        # Assigning to a view of each column is faster than assigning whole
        # rows.
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
        """Adds the row of a tick.

        Args:
            report: The controller's report.
            executed: The command that the robot received, shape (n_u,).
            mode: Mode of the supervisor, one of `MODES`.
            map_version: Version of the map that the tick used.
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
        """Passes the rows in memory to the operating system."""
        rows, self._count = self._rows[: self._count], 0
        problem = self._file.append(rows.tobytes())
        if problem:
            self._lost += len(rows)
            self.trouble = (
                f"{self._file.path.name} lacks {self._lost} ticks: {problem}"
            )

    def close(self) -> None:
        """Writes the rows in memory, and closes the file.

        `trouble` states if the file no longer exists.
        """
        self.flush()
        problem = self._file.close()
        if problem:
            self.trouble = f"{self._file.path} {problem}"


@dc.dataclass(frozen=True, eq=False)
class RunLog:
    """The log of a run, read from its file.

    Attributes:
        period: Control period [s].
        statuses: Names of the statuses. The rows' field `status` contains their
            indices.
        modes: Names of the supervisor's modes. The rows' field `mode` contains
            their indices.
        rows: The ticks, shape (T,), of type `row_type`.
    """

    period: float
    statuses: tuple[str, ...]
    modes: tuple[str, ...]
    rows: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)

    def between(self, start: float, end: float) -> "RunLog":
        """Returns the ticks from `start` up to and including `end` [s]."""
        first = np.searchsorted(self.rows["time"], start, "left")
        last = np.searchsorted(self.rows["time"], end, "right")
        return dc.replace(self, rows=self.rows[first:last])

    def report(
        self, k: int, clearances: Clearances | None = None
    ) -> TickReport:
        """Restores the logged part of the controller's report of a tick.

        Args:
            k: Index of the row.
            clearances: Clearances for the report, since the log contains only
                the smallest clearance of a tick. Rows with the smallest
                distance are marked as `tight`. If it is None, the report has no
                clearances.
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
            aim=Aim.of(np.vstack([row["X_WT"], [0.0, 0.0, 0.0, 1.0]])),
        )


@reads_file
def read_log(path: Path) -> RunLog:
    """Reads the log of a run, and ignores an incomplete last row.

    Args:
        path: The file.

    Raises:
        FileError: The file cannot be read, is not a log, or is damaged.
        FieldError: A field of the log's header is invalid.
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
    """Raises an error if a row contains values that no run can produce."""
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
