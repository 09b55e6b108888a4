"""`remosplat run` says what its map knows, and whether that suffices."""

import dataclasses as dc
import io
import json
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.commands.teleop import MAP_KNOWLEDGE
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    write_report,
)
from remosplat_drake.splat.codecs.ply import read_ply, write_ply

REHEARSED = ("--hardware", "--rehearsal")
TABLE = models_dir() / "scenes" / "table"


@pytest.fixture
def table(tmp_path) -> Path:
    """The shipped table's splat with a scenario, and no report beside it."""
    (tmp_path / "splat.ply").write_bytes((TABLE / "splat.ply").read_bytes())
    (tmp_path / "table.yaml").write_text(
        "Table:\n"
        f"  scene: {{splat: splat.ply, truth: {TABLE / 'scene.json'}}}\n"
        "  time_limit: 0.1\n"
    )
    return tmp_path / "table.yaml"


def report(scenario: Path, map_error: float) -> None:
    splat = scenario.parent / "splat.ply"
    write_report(splat, QualityReport(map_error=map_error))


def drive(scenario: Path, *flags: str, scene: str = "{}") -> int:
    text = f"{{scene: {scene}}}"
    output = str(scenario.parent / "out")
    common = "--headless", "--scenario-text", text, "--output", output
    return main(["run", str(scenario), "--without-doctor", *common, *flags])


def metrics(scenario: Path) -> dict:
    return json.loads((scenario.parent / "out" / "metrics.json").read_text())


def fade(scenario: Path, opacity: float) -> None:
    """Makes every splat of the map as faint as that."""
    path = scenario.parent / "splat.ply"
    splat = read_ply(path)
    faint = np.full(len(splat), opacity, np.float32)
    write_ply(path, dc.replace(splat, opacities=faint))
    report(scenario, 0.01)


CROP = "{crop: {lower: [-9, -9, -9], upper: [9, 9, 0.1]}}"
FAR = "{X_WG: {translation: [100, 0, 0]}}"


def warned(scenario: Path) -> list[str]:
    return [warning["name"] for warning in metrics(scenario)["warnings"]]


def test_a_map_without_an_opaque_splat_is_told(table, capsys):
    fade(table, 0.05)
    assert drive(table) == 1
    assert "empty-map" in capsys.readouterr().err
    assert warned(table) == ["empty-map"]


def test_a_map_somewhere_else_is_told(table, capsys):
    report(table, 0.01)
    assert drive(table, scene=FAR) == 1
    assert "empty-map" in capsys.readouterr().err
    assert warned(table) == ["empty-map"]


def test_a_crop_that_removes_the_table_is_told(table, capsys):
    report(table, 0.01)
    assert drive(table, scene=CROP) == 1
    assert "ignored-splats" in capsys.readouterr().err
    assert warned(table) == ["ignored-splats"]


def test_what_the_map_knows_is_told_and_kept(table, capsys):
    report(table, 0.0093)
    assert drive(table) == 1
    told = capsys.readouterr().err.splitlines()
    assert told[0].startswith("map: 47,607 splats, 0 too faint, 0 cropped away")
    assert "of the start: 16," in told[0] and "of target 1: 36," in told[0]
    assert told[1] == (
        "map error: up to 9.3 mm; smallest stopping distance: 21.0 mm"
    )
    kept = metrics(table)
    assert kept["map_summary"]["kept"] == 47607
    assert kept["map_error"] == 0.0093
    assert kept["warnings"] == kept["accepted"] == []


def test_an_unmeasured_map_is_told(table, capsys):
    assert drive(table) == 1
    assert "remosplat quality" in capsys.readouterr().err
    assert warned(table) == ["unknown-map-error"]


# The real robot: what a simulation is warned of is refused


def refused(capsys) -> str:
    """The only line."""
    lines = capsys.readouterr().err.splitlines()
    (line,) = [line for line in lines if "compil" not in line]
    assert line.startswith("remosplat: ")
    return line


def test_no_real_robot_moves_by_an_empty_map(table, capsys):
    fade(table, 0.05)
    assert drive(table, *REHEARSED) == USER_ERROR
    line = refused(capsys)
    assert "--accept empty-map" in line and "47,607 too faint" in line


def test_no_real_robot_moves_by_an_unmeasured_map(table, capsys):
    assert drive(table, *REHEARSED) == USER_ERROR
    assert "--accept unknown-map-error" in refused(capsys)


def test_all_that_is_wrong_is_said_at_once(table, capsys):
    assert drive(table, *REHEARSED, scene=FAR) == USER_ERROR
    line = refused(capsys)
    assert "--accept empty-map --accept unknown-map-error" in line


def test_without_a_terminal_there_is_no_confirmation(
    table, capsys, monkeypatch
):
    """Not even by a pipe that says yes."""
    monkeypatch.setattr("sys.stdin", io.StringIO("unknown-map-error\n"))
    flags = *REHEARSED, "--accept", "unknown-map-error"
    assert drive(table, *flags) == USER_ERROR
    assert "terminal" in capsys.readouterr().err.splitlines()[-1]


# One rule for every stopping distance


def test_a_stopping_distance_that_the_verdict_forbids_is_refused(table, capsys):
    report(table, 0.27)
    assert drive(table) == USER_ERROR
    line = refused(capsys)
    assert "controller.collision.stopping: 0.021 is too small" in line
    assert "at least 0.2720" in line and "--accept map-error" in line


def test_the_map_error_may_be_accepted_and_is_kept(table, capsys):
    report(table, 0.27)
    # What is not needed does not count.
    flags = "--accept", "map-error", "--accept", "empty-map"
    assert drive(table, *flags) == 1
    assert "accepted: map-error: controller.coll" in capsys.readouterr().err
    (accepted,) = metrics(table)["accepted"]
    assert accepted["name"] == "map-error"
    assert "wrong by up to 0.2700" in accepted["problem"]
    assert warned(table) == []


def test_a_warning_may_be_accepted(table):
    assert drive(table, "--accept", "unknown-map-error") == 1
    assert warned(table) == []
    assert metrics(table)["accepted"][0]["name"] == "unknown-map-error"


def test_an_unknown_gate_is_one_line(table, capsys):
    assert drive(table, "--accept", "map-eror") == USER_ERROR
    line = refused(capsys)
    assert "did you mean 'map-error'" in line and "unknown-map-error" in line


def test_inspecting_tells_and_refuses_nothing(table, capsys):
    report(table, 0.27)
    output = str(table.parent / "views.png")
    assert main(["inspect", str(table), "--output", output]) == 0
    told = capsys.readouterr().err
    assert "map: 47,607 splats" in told and "warning: map-error: " in told


# Teleoperation


def operate(table: Path, *flags: str, scene: str = "{}") -> int:
    script = table.with_name("script.yaml")
    script.write_text("steps: [{time: 0, press: hold}]\n")
    text = f"{{mapping: {{enabled: false}}, scene: {scene}}}"
    return main(
        [
            *("teleop", str(table), "--headless", "--duration", "0.1"),
            "--without-doctor",
            *("--session", str(table.parent / "session")),
            *("--trajectory", str(script), "--scenario-text", text),
            *flags,
        ]
    )


def test_an_operator_is_told_what_the_given_map_knows(table, capsys):
    report(table, 0.01)
    assert operate(table, scene=FAR) == 0
    assert "warning: empty-map: " in capsys.readouterr().err
    file = table.parent / "session" / "runs" / "0001" / MAP_KNOWLEDGE
    kept = json.loads(file.read_text())
    assert [warning["name"] for warning in kept["warnings"]] == ["empty-map"]


@pytest.mark.parametrize(
    ("flags", "gate"),
    [
        ([], "map-error"),
        ([*REHEARSED], "map-error"),
        (["--accept", "x"], "x"),
    ],
)
def test_an_operator_is_refused_as_a_run_is(table, capsys, flags, gate):
    report(table, 0.27)
    assert operate(table, *flags) == USER_ERROR
    assert gate in refused(capsys)
    assert not (table.parent / "session").exists()


def test_a_blank_session_has_no_map_to_know(tmp_path, capsys):
    script = tmp_path / "script.yaml"
    script.write_text("steps: [{time: 0, press: hold}]\n")
    session = tmp_path / "session"
    arguments = "StudioLive", "--headless", "--duration", "0.1"
    places = "--session", str(session), "--trajectory", str(script)
    assert main(["teleop", *arguments, *places]) == 0
    assert "map error" not in capsys.readouterr().err
    assert not list(session.rglob(MAP_KNOWLEDGE))
