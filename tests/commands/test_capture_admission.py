"""`reconstruct` refuses a bad capture, repairs it, or takes it as it is."""

import dataclasses as dc
import html

import numpy as np
import pytest

from remosplat_drake.app.map_knowledge import find_map_error
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.commands.main import main
from remosplat_drake.reconstruction.report.quality_report import read_report

pytest.importorskip("PIL")

QUICK = ["--device", "none", "--count", "500"]


def written(folder, capture, **changes) -> str:
    write_capture(folder, dc.replace(capture, **changes))
    return str(folder)


def inverted(capture) -> dict:
    return {"X_WC": np.linalg.inv(capture.X_WC)}


def astray(capture) -> dict:
    """Frame 3 is 0.2 m from where it says."""
    X_WC = capture.X_WC.copy()
    X_WC[3, :3, 3] += [0.15, -0.1, 0.1]
    return {"X_WC": X_WC}


def refusal(capsys) -> str:
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def test_inverted_poses_are_refused_in_one_line(
    scene_capture, tmp_path, capsys
):
    folder = written(tmp_path / "c", scene_capture, **inverted(scene_capture))
    output = tmp_path / "out" / "a.ply"
    assert main(["reconstruct", folder, "-o", str(output), *QUICK]) == 2
    error = refusal(capsys)
    assert f"{folder}: poses look like world-to-camera" in error
    assert "--repair corrects it if possible" in error
    assert "--accept poses" in error
    assert not output.exists()


@pytest.mark.slow
def test_a_repair_tells_what_it_did_and_makes_the_same_splat(
    scene_capture, tmp_path, capsys
):
    right = written(tmp_path / "right", scene_capture)
    wrong = written(
        tmp_path / "wrong", scene_capture, **inverted(scene_capture)
    )
    out = tmp_path / "out"
    commands = {"a": [right], "b": [wrong, "--repair"]}
    for name, flags in commands.items():
        # A refinement would tell the last digits of inverted poses apart.
        flags = [*flags, "-o", str(out / f"{name}.ply"), *QUICK]
        assert main(["reconstruct", *flags, "--align", "off"]) == 0
    assert "repaired: inverted the poses" in capsys.readouterr().out
    reports = [read_report(out / f"{name}.ply") for name in commands]
    assert [report.warnings for report in reports] == [[], []]
    assert reports[1].map_error == pytest.approx(reports[0].map_error, abs=1e-4)


def test_what_is_accepted_goes_with_the_map(scene_capture, tmp_path, capsys):
    folder = written(tmp_path / "c", scene_capture, **astray(scene_capture))
    output = tmp_path / "out" / "a.ply"
    flags = ["-o", str(output), *QUICK]
    assert main(["reconstruct", folder, *flags]) == 2
    assert "frames[3] (images/0003.png)" in refusal(capsys)
    flags += ["--accept", "wrong-frames"]
    assert main(["reconstruct", folder, *flags]) == 0
    report = read_report(output)
    (warning,) = report.warnings
    assert warning.startswith("accepted although wrong-frames: the poses of 1")
    assert warning in report.trust
    page = output.with_suffix(".quality.html").read_text()
    assert f"<li>{html.escape(warning)}</li>" in page
    scenario = output.with_suffix(".yaml")
    assert "# The capture: accepted although wrong" in scenario.read_text()
    error = find_map_error(load_scenario(str(scenario)))
    assert error.warnings == (warning,)


def test_a_name_that_is_no_defect_is_told(tmp_path, capsys):
    flags = ["-o", str(tmp_path / "a.ply"), "--accept", "pose"]
    assert main(["reconstruct", "nowhere", *flags]) == 2
    assert "did you mean 'poses'" in refusal(capsys)


def test_a_repair_that_does_not_suffice_is_refused(
    scene_capture, tmp_path, capsys
):
    """Every pose is another one's: nothing explains that."""
    order = np.random.default_rng(0).permutation(len(scene_capture))
    X_WC = scene_capture.X_WC[order]
    folder = written(tmp_path / "c", scene_capture, X_WC=X_WC)
    flags = ["-o", str(tmp_path / "a.ply"), *QUICK, "--repair"]
    assert main(["reconstruct", folder, *flags]) == 2
    assert "--repair cannot correct it" in refusal(capsys)
