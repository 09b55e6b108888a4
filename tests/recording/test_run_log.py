"""The log of a run: what is written is read, and the rest is no disaster."""

import dataclasses as dc
import json
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.recording.run_log import (
    NO_MAP,
    RunLogWriter,
    read_log,
    row_type,
)
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.supervisor_state import RUNNING
from remosplat_drake.signals.tick_report import RELAXED, TickReport

N_Q, N_U, PERIOD = 3, 2, 0.1


def clearances(*distance: float) -> Clearances:
    n = len(distance)
    return Clearances(
        np.arange(n), np.array(distance), np.zeros((n, 3)), np.ones((n, 3))
    )


def report(k: int, **fields) -> TickReport:
    X_WT = np.eye(4)
    X_WT[:3, 3] = [k, 2, 3]
    values = {
        "time": PERIOD * k,
        "q": np.full(N_Q, float(k)),
        "command": np.full(N_U, 10.0 * k),
        "status": RELAXED,
        "scale": 0.5,
        "clearances": clearances(0.4, 0.1),
        "aim": Aim.of(X_WT),
    }
    return dc.replace(TickReport.before_first(N_Q, N_U), **{**values, **fields})


def writer(path) -> RunLogWriter:
    return RunLogWriter(path, n_q=N_Q, n_u=N_U, period=PERIOD)


@pytest.fixture
def path(tmp_path):
    """A log of 25 ticks."""
    log = writer(tmp_path / "trajectory.log")
    for k in range(25):
        log.append(
            report(k), np.full(N_U, 5.0 * k), mode=RUNNING, map_version=k
        )
    log.close()
    assert log.trouble == ""
    return tmp_path / "trajectory.log"


def test_what_is_written_is_read(path):
    log = read_log(path)
    assert len(log) == 25
    assert log.period == PERIOD
    row = log.rows[7]
    assert row["time"] == pytest.approx(0.7)
    np.testing.assert_array_equal(row["q"], 3 * [7])
    np.testing.assert_array_equal(row["u_commanded"], 2 * [70])
    np.testing.assert_array_equal(row["u_executed"], 2 * [35])
    np.testing.assert_array_equal(row["X_WT"], report(7).X_WT[:3])
    assert row["clearance"] == 0.1
    assert row["scale"] == 0.5
    assert row["map_version"] == 7
    assert log.statuses[row["status"]] == RELAXED
    assert log.modes[row["mode"]] == RUNNING


def test_a_run_alone_has_neither_mode_nor_map(tmp_path):
    log = writer(tmp_path / "log")
    log.append(report(0, clearances=Clearances.none()), np.zeros(N_U))
    log.close()
    row = read_log(tmp_path / "log").rows[0]
    assert row["clearance"] == np.inf
    assert row["map_version"] == NO_MAP
    assert read_log(tmp_path / "log").modes[row["mode"]] == ""


def test_numbers_are_aligned():
    dtype = row_type(10, 9)
    assert dtype.fields is not None
    for field, offset, *_ in dtype.fields.values():
        assert offset % field.base.itemsize == 0
    assert dtype.itemsize % 8 == 0


def test_a_part_of_a_log(path):
    part = read_log(path).between(0.5, 1.05)
    np.testing.assert_allclose(part.rows["time"], np.arange(5, 11) * PERIOD)
    assert len(read_log(path).between(3, 9)) == 0


def test_a_report_is_made_of_a_row(path):
    log = read_log(path)
    again = log.report(7)
    for name in ("time", "q", "command", "status", "scale", "X_WT"):
        np.testing.assert_array_equal(
            getattr(again, name), getattr(report(7), name)
        )
    assert len(again.clearances) == 0
    again = log.report(7, clearances(0.4, 0.1, 0.2))
    assert again.tight.tolist() == [False, True, False]


def test_rows_are_written_once_a_second(tmp_path):
    path = tmp_path / "log"
    log = writer(path)
    for k in range(9):
        log.append(report(k), np.zeros(N_U))
    assert len(read_log(path)) == 0
    log.append(report(9), np.zeros(N_U))
    assert len(read_log(path)) == 10
    log.append(report(10), np.zeros(N_U))
    log.close()
    assert len(read_log(path)) == 11


def test_a_row_that_was_cut_off_is_left_out(path):
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    assert len(read_log(path)) == 24
    path.write_bytes(whole + b"half a row")
    assert len(read_log(path)) == 25


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "No such file"),
        (b"", "not the log"),
        (b"\x93NUMPY", "not the log"),
        (b"[]\n", "not the log"),
        (b'{"format": "remosplat run log", "version": 9}\n', "version 9"),
    ],
)
def test_what_is_no_log_is_an_error_of_the_user(tmp_path, content, problem):
    path = tmp_path / "trajectory.log"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError, match=problem) as caught:
        read_log(path)
    assert caught.value.path == path


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("n_q", -1),
        ("n_q", 10**9),
        ("n_q", 10**30),
        ("n_u", 1.5),
        ("n_u", "7"),
        ("period", "0.02"),
        ("period", 0),
        ("statuses", "ok"),
        ("statuses", [1, 2]),
        ("modes", None),
        ("modes", [["running"]]),
    ],
)
def test_a_damaged_header_names_its_field(path, field, value):
    header, _, rows = path.read_bytes().partition(b"\n")
    changed = json.loads(header) | {field: value}
    path.write_bytes(json.dumps(changed).encode() + b"\n" + rows)
    with pytest.raises(RemoSplatError, match=rf"{path.name}: .*{field}"):
        read_log(path)


def test_a_deep_header_is_no_header(path):
    path.write_bytes(b"[" * 4000 + b"\n")
    with pytest.raises(FileError, match="not the log"):
        read_log(path)


@pytest.mark.parametrize(
    ("field", "value"),
    [("status", 999), ("mode", 999), ("time", np.nan), ("q", np.inf)],
)
def test_rows_that_no_run_writes(path, field, value):
    rows = read_log(path).rows.copy()
    rows[field][3] = value
    header = path.read_bytes().partition(b"\n")[0]
    path.write_bytes(header + b"\n" + rows.tobytes())
    with pytest.raises(FileError, match=f"row 3: {field}"):
        read_log(path)


def test_the_header_says_what_the_numbers_mean(path):
    with open(path, "rb") as file:
        header = json.loads(file.readline())
    assert header["n_q"] == N_Q
    assert "relaxed" in header["statuses"]


def test_memory_does_not_grow_with_the_run(tmp_path):
    log = writer(tmp_path / "log")
    executed = np.zeros(N_U)
    ticks = [report(k) for k in range(10)]
    for tick in ticks:
        log.append(tick, executed)
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    for _ in range(10_000):
        for tick in ticks:
            log.append(tick, executed)
    after, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    log.close()
    assert after - before < 10_000
    assert peak - before < 100_000
    assert len(read_log(tmp_path / "log")) == 100_010


# A process to which the disk is full in the middle of the fifth second of a
# log, and two seconds later is no longer.
_LIMITED = """
import resource, sys
from pathlib import Path
import numpy as np
from test_run_log import N_Q, N_U, report, row_type, writer
path = Path(sys.argv[1])
log = writer(path)
full = path.stat().st_size + 45 * row_type(N_Q, N_U).itemsize
_, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (full, hard))
for k in range(70):
    log.append(report(k), np.zeros(N_U))
print(log.trouble)
resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
for k in range(70, 90):
    log.append(report(k), np.zeros(N_U))
log.close()
"""


def test_a_full_disk_costs_no_row_but_those_that_did_not_fit(tmp_path):
    path = tmp_path / "trajectory.log"
    answer = subprocess.run(
        [sys.executable, "-c", _LIMITED, path],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        check=True,
    )
    assert answer.stdout == "trajectory.log lacks 30 ticks: File too large\n"
    kept = np.r_[0:40, 70:90]
    np.testing.assert_allclose(read_log(path).rows["time"], PERIOD * kept)
