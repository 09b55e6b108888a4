"""The paper's figure 5: what it leaves, and that it does it once."""

import json

import pytest

from apps.studies import push as study
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.commands.main import USER_ERROR
from remosplat_drake.teleop.trajectory_file import load_operator_steps

SCRIPT = "steps: [{time: 0.1, press: hold}, {time: 0.3, press: home}]"


def push(folder, *arguments: str, script: str = SCRIPT) -> int:
    path = folder / "script.yaml"
    path.write_text(script)
    where = ["--script", str(path), "--output", str(folder / "out")]
    return study.main([*where, *arguments])


@pytest.mark.slow
def test_figure_and_numbers_are_written_and_a_run_that_is_there_is_kept(
    tmp_path, capfd, monkeypatch
):
    assert push(tmp_path) == 0
    assert "smallest true clearance" in capfd.readouterr().err
    out = tmp_path / "out"
    assert (out / "figure.png").read_bytes().startswith(b"\x89PNG")
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["true_clearance_min"] > 0.1
    assert metrics["maps"] == 0
    assert metrics["map_clearance_min"] is None
    assert metrics["duration"] == pytest.approx(1.3, abs=0.05)
    # Another script is another run.
    log = out / "session" / "runs" / "0001" / "trajectory.log"
    before = log.stat().st_mtime_ns
    assert push(tmp_path, script=SCRIPT.replace("0.3", "0.2")) == 0
    assert log.stat().st_mtime_ns > before
    # What is there is not run again.
    monkeypatch.delattr(study, "drive")
    (out / "figure.png").unlink()
    assert push(tmp_path, script=SCRIPT.replace("0.3", "0.2")) == 0
    assert (out / "figure.png").exists()
    capfd.readouterr()


def test_without_the_truth_there_is_no_result(tmp_path, capfd):
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("Blind: {}\n")
    assert push(tmp_path, str(scenario)) == USER_ERROR
    assert "scene.truth" in capfd.readouterr().err


def test_the_shipped_script_can_be_followed():
    poses = load_scenario(study.DEFAULT_SCENARIO).teleop.poses
    steps = load_operator_steps(study.SCRIPT, poses)
    assert steps[0].press == "scan"
