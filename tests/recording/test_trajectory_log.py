"""A session writes down what it does; the log says what really was."""

import numpy as np
import pytest
from logged_run import SWAP, LoggedSession, make_session
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.base.errors import FileError
from remosplat_drake.mapping.store.run_folders import find_run
from remosplat_drake.recording.events import MAP, SUPERVISOR, read_events
from remosplat_drake.recording.run_log import RunLog, read_log
from remosplat_drake.recording.trajectory_log import EVENTS, LOG, TrajectoryLog


@pytest.fixture(scope="module")
def logged(tmp_path_factory) -> LoggedSession:
    return make_session(tmp_path_factory.mktemp("log") / "session", 1.0)


@pytest.fixture(scope="module")
def log(logged) -> RunLog:
    return read_log(find_run(logged.session.folder) / LOG)


def test_the_log_holds_what_a_recorder_keeps(logged, log):
    rows, trajectory = log.rows, logged.trajectory
    assert len(rows) == len(trajectory) == 100
    np.testing.assert_array_equal(rows["time"], trajectory.time)
    np.testing.assert_array_equal(rows["q"], trajectory.q[:-1])
    np.testing.assert_array_equal(rows["u_executed"], trajectory.u)
    np.testing.assert_array_equal(rows["clearance"], trajectory.clearance)
    statuses = np.array(log.statuses)[rows["status"]]
    np.testing.assert_array_equal(statuses, trajectory.status)
    target = logged.world.truth.X_WE_target.GetAsMatrix34()
    np.testing.assert_allclose(rows["X_WT"], np.tile(target, (100, 1, 1)))


def test_each_row_names_the_map_that_its_tick_asked(logged, log):
    rows = log.rows
    expected = rows["time"] >= SWAP
    np.testing.assert_array_equal(rows["map_version"], expected)
    reach = logged.scenario.controller.collision.influence
    for row in rows[40:60]:
        field = logged.maps[row["map_version"]].field
        spheres = logged.world.robot.spheres_at(row["q"])
        assert field.clearances(spheres, reach).minimum() == row["clearance"]


def test_events_are_told_in_order(logged):
    events = read_events(find_run(logged.session.folder) / EVENTS)
    assert [(event.kind, event.version) for event in events] == [
        (SUPERVISOR, None),
        (MAP, 0),
        (MAP, 1),
    ]
    assert events[-1].time == pytest.approx(SWAP, abs=0.011)
    assert events[-1].text == "half"


def test_a_run_without_a_tick_has_a_log_too(tmp_path):
    log = TrajectoryLog(folder=tmp_path, n_q=3, n_u=2, period=0.1)
    log.close()
    assert len(read_log(tmp_path / LOG)) == 0
    assert read_events(tmp_path / EVENTS) == []


def test_the_files_of_another_run_are_not_touched(tmp_path):
    TrajectoryLog(folder=tmp_path, n_q=3, n_u=2, period=0.1).close()
    before = (tmp_path / LOG).read_bytes()
    with pytest.raises(FileError, match="exists"):
        TrajectoryLog.AddToBuilder(
            DiagramBuilder(),
            inputs={},
            folder=tmp_path,
            n_q=3,
            n_u=2,
            period=0.1,
        )
    assert (tmp_path / LOG).read_bytes() == before
