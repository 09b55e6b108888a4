"""The command as a user runs it, on a small rendered scene."""

import numpy as np
import pytest

from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.commands.main import main
from remosplat_drake.reconstruction.report.quality_report import (
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
    assert "Distances are right to" in " ".join(output.split())
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
