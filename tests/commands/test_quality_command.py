"""The command as a user runs it, on a small rendered scene."""

import dataclasses as dc
import io
import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from remosplat_drake.app.map_grade import FAIR, GOOD, POOR, UNKNOWN, grade_map
from remosplat_drake.app.map_knowledge import MapError
from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.commands.main import main
from remosplat_drake.commands.quality import print_report
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    page_path,
    read_report,
    report_path,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.codecs.ply import write_ply


@pytest.fixture(scope="module")
def files(scene, scene_capture, tmp_path_factory):
    """A folder with a capture, the splat of its surfels and the truth."""
    folder = tmp_path_factory.mktemp("quality")
    write_capture(folder / "capture", scene_capture)
    surfels = surfels_from_capture(scene_capture, count=5000, stride=1)
    splat = splat_of_surfels(surfels)
    write_ply(folder / "scene.ply", splat, with_normals=False)
    write_rmmi(folder / "scene.json", scene)
    np.savetxt(folder / "pose.txt", np.eye(4))
    return folder


def test_writes_report_and_page_beside_the_splat(files, capsys):
    arguments = ["quality", str(files / "scene.ply"), str(files / "capture")]
    arguments += ["--truth", str(files / "scene.json"), "--points", "200"]
    arguments += ["--focus", "1", "0", "0.6", "--method", "untrained"]
    arguments += ["--capture-pose", str(files / "pose.txt")]
    assert main([*arguments, "--held-out", "6"]) == 0
    output = capsys.readouterr().out
    said = " ".join(output.split())
    assert "99 % of the distances have an error of at most" in said
    report = read_report(files / "scene.ply")
    assert report.method == "untrained"
    assert report.images.views == 2
    assert report.images.held_out
    assert len(report.distances) == 4
    # Twelve small images see the scene in pixels of one to two centimetres.
    assert 0 < report.map_error < 0.03
    assert report.coverage.lower == [0.0, -1.0, 0.0]
    page = page_path(files / "scene.ply").read_text()
    assert report.trust in page


def test_the_report_as_json(files, tmp_path, capsys):
    arguments = ["quality", str(files / "scene.ply"), str(files / "capture")]
    arguments += ["--points", "20", "--output", str(tmp_path), "--json"]
    assert main(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    names = {field.name for field in dc.fields(QualityReport)}
    assert document.keys() == {*names, "grade", "page"}
    assert document["grade"] in (GOOD, FAIR, POOR)
    assert Path(document["page"]).is_file()


@pytest.mark.parametrize(
    ("error", "grade"),
    [
        (MapError(0.019), GOOD),
        (MapError(0.0191), FAIR),
        (MapError(0.001, warnings=("blurred",)), FAIR),
        (MapError(0.048), POOR),
        (MapError(trouble="it was not measured"), UNKNOWN),
    ],
)
def test_a_map_is_graded_by_the_distances_that_are_safe_in_it(error, grade):
    """The usual stopping distance is 21 mm, of which 2 mm are the margin."""
    assert grade_map(error) == grade


def test_the_verdict_is_coloured_in_a_terminal_only(monkeypatch):
    report = QualityReport(remaining_error=0.003, trust="Trust it.")

    def printed(**options) -> str:
        console = Console(file=io.StringIO(), **options)
        print_report(console, report)
        return console.file.getvalue()

    monkeypatch.delenv("NO_COLOR", raising=False)
    terminal = {"force_terminal": True, "color_system": "standard"}
    assert "\x1b[1;32mgood\x1b[0m Trust it." in printed(**terminal)
    assert "\x1b" not in printed()
    assert "good Trust it." in printed()
    monkeypatch.setenv("NO_COLOR", "1")
    assert "32m" not in printed(**terminal)


def test_another_folder_for_the_report(files, tmp_path):
    arguments = ["quality", str(files / "scene.ply"), str(files / "capture")]
    arguments += ["--points", "20", "--output", str(tmp_path)]
    assert main(arguments) == 0
    name = report_path(files / "scene.ply").name
    assert (tmp_path / name).is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing.ply", "."], "nothing.ply: no such file"),
        (["scene.ply", "nowhere"], "nowhere: no such file"),
        (["scene.ply", "capture", "--held-out", "0"], "must be positive"),
        (["scene.ply", "capture", "--seed", "-1"], "must not be negative"),
        (["scene.ply", "capture", "--reach", "inf"], "must be finite"),
        (["scene.ply", "capture", "--truth", "pose.txt"], "pose.txt"),
        (["scene.ply", "capture", "--output", "scene.ply"], "not a folder"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(
    files, monkeypatch, capsys, arguments, message
):
    monkeypatch.chdir(files)
    assert main(["quality", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
