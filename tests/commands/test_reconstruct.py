"""From a scene's file to a splat, on the command line."""

import pytest

from remosplat_drake.commands.main import main
from remosplat_drake.reconstruction.quality_report import read_report
from remosplat_drake.resources import models_dir
from remosplat_drake.scenario import LoadScenario
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.world import load_world

pytest.importorskip("PIL")

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
    assert reconstruct(folder, output, *flags) == 0
    return output


def test_the_splat_comes_with_its_report_and_its_pictures(made):
    assert 500 < len(read_splat(made)) <= 3000
    report = read_report(made)
    assert "refined on the CPU" in report.method
    assert report.images.held_out and report.images.views == 3
    # The capture says what it shows, so the truth is known.
    assert {d.reference for d in report.distances} == {"capture", "truth"}
    assert "<html" in made.with_suffix(".quality.html").read_text()
    assert not made.with_suffix(".training.pt").exists()


def test_the_scenario_runs(made, capsys):
    scenario = str(made.with_suffix(".yaml"))
    text = "{time_limit: 0.1}"
    flags = ["--headless", "--scenario-text", text]
    assert main(["run", scenario, *flags]) in (0, 1)
    world = load_world(LoadScenario(scenario))
    assert world.splat_W is not None
    assert (
        world.field.clearances(world.robot.spheres_at(world.q0)).minimum() > 0.1
    )


def test_floor_and_untrained_discs(folder, tmp_path, capsys):
    output = tmp_path / "splat.ply"
    flags = ["--device", "none", "--count", "500", "--floor"]
    assert reconstruct(folder, output, *flags) == 0
    assert "floor: " in capsys.readouterr().out
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
        (["--focus", "0", "nan", "0"], "--focus: must be finite"),
        (["--focus", "50", "0", "0"], "--focus: is far from all"),
        (["--random-points", "2"], "random_points: must be 0 or at least 4"),
        (["--held-out", "1"], "--held-out"),
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
    assert "no format has this name's end" in capsys.readouterr().err


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
