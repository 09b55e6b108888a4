"""From a scene's file to a splat, on the command line."""

import dataclasses as dc
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from runs import PROGRESS

from remosplat_drake.app.map_knowledge import find_map_error, map_error_gates
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base import progress
from remosplat_drake.base.resources import models_dir
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.readers.nerfstudio import write_capture
from remosplat_drake.commands.main import main
from remosplat_drake.commands.suggested_entry import suggested_entry
from remosplat_drake.commands.suggested_scenario import write_scenario
from remosplat_drake.reconstruction.alignment.cameras_file import with_cameras
from remosplat_drake.reconstruction.report.quality_report import (
    pose_path,
    read_report,
)
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.reach import arm_reach
from remosplat_drake.safety.gates import MAP_ERROR
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.task.suggestion import Suggestion

pytest.importorskip("PIL")

THREE_LINK = str(Path(__file__).parents[1] / "data" / "three_link.yaml")
SCENE = str(models_dir() / "scenes" / "table" / "scene.json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture")
    size = ["--views", "12", "--width", "120", "--height", "90", "--floor"]
    assert main(["render-capture", SCENE, str(folder), *size]) == 0
    return folder


def reconstruct(folder, output, *flags: str) -> int:
    return main(["reconstruct", str(folder), "-o", str(output), *flags])


@pytest.fixture(scope="module")
def made(folder, tmp_path_factory):
    """A splat from the command line, small and refined."""
    output = tmp_path_factory.mktemp("made") / "my_table.ply"
    flags = ["--device", "cpu", "--count", "3000", "--held-out", "4"]
    assert reconstruct(folder, output, *flags, "--up", "capture") == 0
    return output


def test_the_splat_comes_with_its_report_and_its_pictures(made):
    splat = read_splat(made)
    assert len(splat) > 500
    assert splat.uncertainty is not None and splat.uncertainty.min() > 0
    report = read_report(made)
    assert "refined on the CPU" in report.method
    assert report.images.held_out and report.images.views == 3
    # The capture says what it shows, so the truth is known.
    assert {d.reference for d in report.distances} == {"capture", "truth"}
    assert report.remaining_error <= report.map_error
    assert splat.uncertainty.max() >= report.uncertainty > 0
    assert "<html" in made.with_suffix(".quality.html").read_text()
    assert not made.with_suffix(".training.pt").exists()


def test_the_scenario_runs(made, capsys):
    scenario = str(made.with_suffix(".yaml"))
    text = "{time_limit: 0.1}"
    # So few and small views do not make a splat that suffices.
    flags = ["--headless", "--scenario-text", text, "--accept", "map-error"]
    assert main(["run", scenario, *flags]) in (0, 1)
    world = load_world(load_scenario(scenario))
    assert world.splat_W is not None
    assert (
        world.field.clearances(world.robot.spheres_at(world.q0)).minimum() > 0.1
    )


def test_the_scenario_carries_the_verdict(made, tmp_path):
    """Even where the splat goes without its report."""
    report = read_report(made)
    moved = tmp_path / made.name
    shutil.copy(made, moved)
    shutil.copy(made.with_suffix(".yaml"), tmp_path)
    scenario = load_scenario(str(moved.with_suffix(".yaml")))
    error = find_map_error(scenario)
    assert error.largest is not None
    rest = report.remaining_error
    assert rest <= error.largest < rest + 1.001e-4


@pytest.fixture(scope="module")
def written(folder, made, tmp_path_factory):
    """Writes the scenario of a splat that is wrong by so much."""
    capture = read_capture(folder)
    splat = tmp_path_factory.mktemp("written") / "a_splat.ply"
    shutil.copy(made, splat)

    def _written(map_error: float, **options) -> Path:
        workspace = Workspace.of_capture(capture)
        write_scenario(
            splat, read_splat(made), capture, workspace, map_error, **options
        )
        return splat.with_suffix(".yaml")

    return _written


@pytest.mark.parametrize(
    ("map_error", "stopping"),
    [
        (0.004, 0.021),
        (0.019, 0.021),
        # Rounded up: 20.1 mm and 2 mm, to a whole millimetre.
        (0.02003, 0.023),
        (0.0309999, 0.033),
        (0.0479, 0.050),
    ],
)
def test_its_stopping_distance_is_safe(written, map_error, stopping):
    scenario = load_scenario(str(written(map_error)))
    if stopping == 0.050:
        # As far from the scene as the target may be: nothing would arrive.
        (gate,) = map_error_gates(scenario, find_map_error(scenario))
        assert gate.name == MAP_ERROR
        return
    assert scenario.controller.collision.stopping == stopping
    assert map_error_gates(scenario, find_map_error(scenario)) == []


def test_a_splat_safe_from_272_mm_on_does_not_run_at_21(written, capsys):
    path = written(0.27)
    assert "# from 272 mm on." in path.read_text()
    assert "`remosplat run` refuses" in path.read_text()
    flags = ["--headless", "--scenario-text", "{time_limit: 0.1}"]
    assert main(["run", str(path), *flags]) == 2
    assert "valid: at least 0.2720" in capsys.readouterr().err
    assert main(["run", str(path), *flags, "--accept", "map-error"]) == 1


@pytest.mark.smoke
def test_floor_and_untrained_discs(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(progress, "BEGUN", 0.001)
    monkeypatch.setattr(progress, "PERIOD", 0.001)
    output = tmp_path / "splat.ply"
    flags = ["--device", "none", "--count", "500", "--floor"]
    assert reconstruct(folder, output, *flags) == 0
    said = capsys.readouterr()
    assert "the floor was found" in said.out
    # Where there is no terminal, too, it says how far it is.
    lines = said.err.splitlines()
    assert all(re.match(PROGRESS, line) for line in lines)
    stages = {line.partition(":")[0] for line in lines}
    # One that takes long: a busy machine may sleep through short ones.
    assert "finding what was seen" in stages
    report = read_report(output)
    assert "refined" not in report.method
    # The floor is not quite where the truth has it, so it is not used.
    assert {d.reference for d in report.distances} == {"capture"}
    # What the floor did to the capture is found again.
    assert main(["quality", str(output), str(folder), "--held-out", "8"]) == 0
    assert read_report(output).map_error == pytest.approx(
        report.map_error, abs=1e-6
    )


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--count", "0"], "--count: must be positive"),
        (["--count", "99"], "--count: must be at least 100"),
        (["--seed", "-1"], "--seed: must not be negative"),
        (["--stride", "0"], "--stride: must be positive"),
        (["--keyframes", "-1"], "--keyframes: must not be negative"),
        (
            ["--keyframes", "9", "--length", *"0 9 9 1 9 9 1".split()],
            "--keyframes: would change the frame numbers that --length uses",
        ),
        (["--focus", "0", "nan", "0"], "--focus: must be finite"),
        (["--focus", "50", "0", "0"], "--focus: is far from all"),
        (["--random-points", "2"], "random_points: must be 0, or 4 or more"),
        (["--held-out", "1"], "--held-out"),
        (
            ["--refine-cameras", "--device", "cpu"],
            "--refine-cameras: needs training",
        ),
        (["--max-depth", "0.01"], "depth"),
        (["--floor", "--truth", "a.json"], "--truth"),
        (["--format", "tum"], "intrinsics"),
    ],
)
def test_one_line_says_what_is_wrong(folder, tmp_path, capsys, flags, message):
    assert reconstruct(folder, tmp_path / "a.ply", *flags) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_the_name_of_the_splat_is_checked_first(tmp_path, capsys):
    assert reconstruct("nowhere", tmp_path / "a.txt") == 2
    assert "unknown suffix" in capsys.readouterr().err


def test_one_line_says_what_is_missing(tmp_path, capsys):
    assert reconstruct("nowhere", tmp_path / "a.ply") == 2
    assert "nowhere: no such file" in capsys.readouterr().err


def test_training_without_gsplat_or_cuda_says_so(folder, tmp_path, capsys):
    if torch_sees_cuda():
        pytest.skip("there is a CUDA device")
    assert reconstruct(folder, tmp_path / "a.ply", "--device", "cuda") == 2
    error = capsys.readouterr().err
    assert "remosplat-drake[gpu]" in error or "CUDA" in error


def torch_sees_cuda() -> bool:
    try:
        import torch
    except ImportError:
        return False
    return torch.cuda.is_available()


@pytest.mark.gpu
def test_training_on_cuda(folder, tmp_path):
    if not torch_sees_cuda():
        pytest.skip("needs a CUDA device")
    output = tmp_path / "trained.ply"
    flags = ["--count", "3000", "--steps", "50", "--held-out", "4"]
    assert reconstruct(folder, output, "--device", "cuda", *flags) == 0
    assert "trained by gsplat" in read_report(output).method


@pytest.mark.gpu
def test_cameras_are_trained_on_cuda_and_kept(folder, tmp_path):
    if not torch_sees_cuda():
        pytest.skip("needs a CUDA device")
    output = tmp_path / "trained.ply"
    size = ["--count", "3000", "--steps", "50", "--held-out", "4"]
    flags = ["--device", "cuda", "--refine-cameras", "--up", "floor"]
    assert reconstruct(folder, output, *size, *flags) == 0
    report = read_report(output)
    assert "with its cameras as unknowns" in report.method
    given = read_capture(folder)
    refined = with_cameras(given, output)
    assert not np.array_equal(refined.K, given.K)
    # With the cameras beside the splat, its images look as they did.
    assert main(["quality", str(output), str(folder), "--held-out", "4"]) == 0
    again = read_report(output)
    assert again.images.psnr == pytest.approx(report.images.psnr, abs=0.01)


def test_where_up_is_unknown_there_is_no_scenario(
    folder, made, tmp_path, capsys
):
    """The robot would stand on its side in the first camera's frame."""
    assert made.with_suffix(".yaml").exists()
    output = tmp_path / "a.ply"
    flags = ["--device", "none", "--count", "500"]
    assert reconstruct(folder, output, *flags, "--up", "none") == 0
    assert "no scenario: in the capture's frame" in capsys.readouterr().out
    assert not output.with_suffix(".yaml").exists()


def test_a_handheld_capture_comes_out_upright(scene_capture, tmp_path, capsys):
    X_CW = np.linalg.inv(scene_capture.X_WC[0])
    handheld = dc.replace(scene_capture, X_WC=X_CW @ scene_capture.X_WC)
    write_capture(tmp_path / "capture", handheld)
    output = tmp_path / "a.ply"
    flags = ["--device", "none", "--count", "500"]
    assert reconstruct(tmp_path / "capture", output, *flags) == 0
    X_FW = np.loadtxt(pose_path(output))
    assert (X_FW @ X_CW)[2, 2] > np.cos(1e-3)
    assert (X_FW @ X_CW)[2, 3] == pytest.approx(0, abs=1e-3)


def test_the_task_is_for_the_robot_that_is_named(written):
    """An arm cannot drive up to the table; it reaches from where it stands."""
    scenario = load_scenario(str(written(0.004, robot="ur5e")))
    assert scenario.robot.model == "ur5e"
    assert scenario.robot.base_pose is None
    world = load_world(scenario)
    standing = world.robot.spheres_at(world.q0)
    assert world.field.clearances(standing).minimum() > 0
    p_WT = np.array(scenario.targets[0].translation)
    assert np.linalg.norm(p_WT) < arm_reach(world.robot)


def test_a_map_that_is_moved_to_an_arm_is_written_with_its_pose():
    X_WG = RigidTransform(RollPitchYaw(0, 0, 0.5), [1, 2, 0])
    task = Suggestion(None, RigidTransform([0.4, 0, 0.3]), X_WG)
    entry = suggested_entry("a.ply", task, "ur5e", None)
    assert entry["scene"]["X_WG"] == {
        "translation": [1, 2, 0],
        "rpy_deg": [0, 0, 28.65],
    }


def test_an_unknown_robot_is_told_first(tmp_path, capsys):
    flags = ["--robot", "fankie"]
    assert reconstruct("nowhere", tmp_path / "a.ply", *flags) == 2
    assert "did you mean 'frankie'" in capsys.readouterr().err
