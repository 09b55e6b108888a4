"""`remosplat replay`: its output, and its errors about missing parts."""

import dataclasses as dc
import shutil

import numpy as np
import pytest
from logged_run import SWAP, make_session

from remosplat_drake.app.recorded_run import load_recorded_run
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.recording.events import EventWriter, read_events
from remosplat_drake.recording.run_log import read_log
from remosplat_drake.recording.trajectory_log import EVENTS, LOG


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("replay") / "session"
    make_session(folder, 0.75)
    return folder


@pytest.fixture
def session(made, tmp_path):
    """A copy that a test may damage."""
    return shutil.copytree(made, tmp_path / "session")


def replay(*arguments) -> int:
    return main(["replay", *map(str, arguments), "--no-hold"])


def test_page_and_figure_are_written(session, tmp_path, capsys):
    page, figure = tmp_path / "replay.html", tmp_path / "figure.svg"
    assert replay(session, "--save-html", page, "--figure", figure) == 0
    assert 'id="packed"' in page.read_text()
    assert "<svg" in figure.read_text()
    said = capsys.readouterr().err
    assert "0.00 to 0.74 s, 75 ticks" in said
    assert "map: half" in said
    assert "true clearance: at least" in said


def test_a_part_is_replayed_at_another_rate(session, capsys):
    arguments = ["--from", SWAP, "--to", "0.6", "--rate", "0.25"]
    assert replay(session, "--run", "1", *arguments) == 0
    said = capsys.readouterr().err
    assert "0.50 to 0.60 s, 11 ticks" in said
    assert "map: all" not in said


def test_a_map_that_is_lost_is_left_out(session, capsys):
    (session / "maps" / "map_0001.rsmap").write_bytes(b"damaged")
    assert replay(session) == 0
    assert "map_0001.rsmap" in capsys.readouterr().err.replace("\n", "")


def test_a_missing_file_is_named_as_it_was_given(tmp_path, capsys):
    path = tmp_path / "nofile.mcap"
    assert replay(path) == USER_ERROR
    said = capsys.readouterr().err
    problem = "does not exist; give the folder of a session"
    assert said == f"remosplat: {path}: {problem}\n"


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--run", "3"], "run: no 3; valid: 1"),
        (
            ["--from", "5"],
            "no tick lies between 5.0 and inf s; valid: 0.00 to 0.74",
        ),
        (["--figure", "figure.doc"], "valid: pdf, png, svg"),
        (["--save-html", "."], "is a folder"),
    ],
)
def test_an_impossible_wish_is_one_line(session, capsys, arguments, problem):
    assert replay(session, *arguments) == USER_ERROR
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert problem in said


@pytest.mark.parametrize(
    ("lost", "problem"),
    [
        ("session.json", "session.json: no such file"),
        ("scenario.yaml", "scenario.yaml: no such file"),
        ("runs", "holds no recorded runs"),
        ("runs/0001/trajectory.log", "trajectory.log: No such file"),
        ("runs/0001/events.jsonl", "events.jsonl: No such file"),
    ],
)
def test_a_session_that_lacks_something(session, capsys, lost, problem):
    path = session / lost
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    assert replay(session) == USER_ERROR
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert problem in said


def test_a_run_by_the_time_of_day_starts_at_zero(session):
    path = session / "runs" / "0001" / LOG
    header, newline, _ = path.read_bytes().partition(b"\n")
    rows = read_log(path).rows
    rows["time"] += 1_700_000_000
    path.write_bytes(header + newline + rows.tobytes())
    path = session / "runs" / "0001" / EVENTS
    events = [
        dc.replace(event, time=event.time + 1_700_000_000)
        for event in read_events(path)
    ]
    path.unlink()
    writer = EventWriter(path)
    for event in events:
        writer.append(event)
    writer.close()
    recorded = load_recorded_run(session)
    np.testing.assert_allclose(
        recorded.log.rows["time"], 0.01 * np.arange(75), atol=1e-6
    )
    assert 0.48 < recorded.events[-1].time < 0.51


def test_a_run_that_died_at_once_has_no_replay(session, capsys):
    log = session / "runs" / "0001" / "trajectory.log"
    log.write_bytes(log.read_bytes().splitlines(keepends=True)[0])
    assert replay(session) == USER_ERROR
    assert "holds no ticks" in capsys.readouterr().err
