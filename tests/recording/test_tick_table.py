"""A table of ticks says to the last digit what their reports say."""

import dataclasses as dc
import tempfile

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.recording.tick_table import TickTable
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.separation import Separation
from remosplat_drake.signals.tick_report import STATUSES, TickReport

N_Q, N_U = 3, 2


def some_reports(count: int) -> list[TickReport]:
    """Reports of any numbers; phases come and go."""
    rng = np.random.default_rng(4)

    def report(k: int) -> TickReport:
        rows = int(rng.integers(4))
        none = np.zeros((rows, 3))
        distance = rng.normal(size=rows)
        phases = rng.permutation(["solve", "build", "total"])[: k % 4]
        is_near = rng.random() < 0.5
        return dc.replace(
            TickReport.before_first(N_Q, N_U),
            time=0.1 * k,
            q=rng.normal(size=N_Q),
            command=rng.normal(size=N_U),
            status=str(rng.choice(STATUSES[:3])),
            scale=rng.random(),
            clearances=Clearances(np.arange(rows), distance, none, none),
            line_deviation=rng.random() if is_near else float("nan"),
            separation=Separation("hand", "Ada", *rng.random(2))
            if is_near
            else None,
            timings={str(phase): rng.random() for phase in phases},
        )

    return [report(k) for k in range(count)]


def some_movers(time: float) -> Movers:
    rng = np.random.default_rng(round(1e3 * time))
    turn = RollPitchYaw(rng.uniform(-3, 3, 3))
    things = [
        Mover(
            name,
            RigidTransform(turn, rng.normal(size=3)),
            *(rng.random(3), rng.random(), rng.normal(size=3)),
            *(rng.normal(size=3), *rng.random(4)),
        )
        for name in ("Ada", "a door")
    ]
    return Movers(time, things)


def filled(reports, movers=None, block: int | None = None) -> TickTable:
    table = TickTable(N_Q, N_U, block=block)
    for i, report in enumerate(reports):
        table.append(report, 2.0 * report.command, movers and movers[i])
    return table


def test_columns_are_what_the_reports_say():
    reports, q_end = some_reports(40), np.arange(3.0)
    table = filled(reports)
    found = table.trajectory(q_end)
    expected = {
        "time": [r.time for r in reports],
        "q": [*(r.q for r in reports), q_end],
        "u": [2.0 * r.command for r in reports],
        "status": [r.status for r in reports],
        "scale": [r.scale for r in reports],
        "clearance": [r.clearances.minimum() for r in reports],
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(getattr(found, name), np.array(values))
    # As wide as the longest of those that came up, not of all there are.
    assert found.status.dtype == np.array(expected["status"]).dtype
    assert list(found.timings) == ["build", "solve", "total"]
    for phase, column in found.timings.items():
        values = [r.timings.get(phase, np.nan) for r in reports]
        np.testing.assert_array_equal(column, values)
    np.testing.assert_array_equal(
        table.line_deviation, [r.line_deviation for r in reports]
    )
    np.testing.assert_array_equal(
        table.separation_margin,
        [r.separation.margin if r.separation else np.nan for r in reports],
    )
    assert found.movers == ()


def test_no_tick_is_a_trajectory_too():
    empty = filled([]).trajectory(np.zeros(N_Q))
    assert len(empty) == 0
    assert empty.q.shape == (1, N_Q)
    assert empty.u.shape == (0, N_U)
    assert empty.timings == {}


def test_what_moved_is_unpacked_to_the_last_digit():
    reports = some_reports(6)
    heard = [some_movers(0.1 * (k // 2)) for k in range(0, 6, 2)]
    movers = [heard[k // 2] for k in range(6)]
    found = filled(reports, movers).trajectory(np.zeros(N_Q)).movers
    assert len(found) == 6
    for there, here in zip(found, movers, strict=True):
        assert there.stamp == here.stamp
        assert [m.name for m in there] == [m.name for m in here]
        for a, b in zip(there.arrays.values, here.arrays.values, strict=True):
            np.testing.assert_array_equal(a, b)


def test_ticks_of_the_same_message_share_it():
    """A robot ticks a hundred times a second, a camera looks ten times."""
    heard = some_movers(0.0)
    table = filled(some_reports(50), [heard] * 50)
    assert len({id(packed) for packed in table._movers}) == 1


def assert_same(a: TickTable, b: TickTable) -> None:
    """To the last digit."""
    one, other = (t.trajectory(np.zeros(N_Q)) for t in (a, b))
    assert len(a) == len(b) == len(one)
    for name in ("time", "q", "u", "status", "scale", "clearance"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert list(one.timings) == list(other.timings)
    for phase, column in one.timings.items():
        np.testing.assert_array_equal(other.timings[phase], column)
    np.testing.assert_array_equal(a.line_deviation, b.line_deviation)
    np.testing.assert_array_equal(a.separation_margin, b.separation_margin)
    assert len(one.movers) == len(other.movers)
    for mine, theirs in zip(one.movers, other.movers, strict=True):
        assert mine.stamp == theirs.stamp
        assert [m.name for m in mine] == [m.name for m in theirs]
        for x, y in zip(mine.arrays.values, theirs.arrays.values, strict=True):
            np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("block", [1, 7, 40, 41])
@pytest.mark.parametrize("moves", [False, True])
def test_ticks_on_the_disk_are_those_of_memory(block, moves):
    """Phases come and go, and several ticks share a message."""
    reports = some_reports(40)
    heard = [some_movers(0.1 * k) for k in range(14)]
    movers = [heard[k // 3] for k in range(40)] if moves else None
    table = filled(reports, movers, block)
    assert len(table._time) == 40 % block
    assert_same(table, filled(reports, movers))


def test_a_full_disk_loses_ticks_and_says_so(monkeypatch):
    def full(**_):
        raise OSError(28, "No space left on device")

    reports = some_reports(25)
    monkeypatch.setattr(tempfile, "TemporaryFile", full)
    table = filled(reports, None, 10)
    assert table.trouble == (
        "the trajectory lacks 20 ticks: No space left on device"
    )
    monkeypatch.undo()
    for report in reports[:6]:
        table.append(report, 2.0 * report.command)
    assert_same(table, filled([*reports[20:], *reports[:6]]))


@pytest.mark.parametrize("since", [-1.0, 0.0, 1.23, 3.9])
def test_the_oldest_ticks_are_forgotten(since):
    reports = some_reports(40)
    kept = [report for report in reports if report.time >= since]
    movers = [some_movers(report.time) for report in reports]
    table = filled(reports, movers)
    table.forget_before(since)
    rest = filled(kept, movers[-len(kept) :])
    assert len(table) == len(kept)
    a, b = (t.trajectory(np.zeros(N_Q)) for t in (table, rest))
    for name in ("time", "q", "u", "status", "scale", "clearance"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    for phase, column in b.timings.items():
        np.testing.assert_array_equal(a.timings[phase], column)
    assert [m.stamp for m in a.movers] == [m.stamp for m in b.movers]
