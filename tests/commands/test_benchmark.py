"""`remosplat benchmark` from its command line."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from own_cache import use_cache
from rich.text import Text

from remosplat_drake.benchmark.methods import GROUPS, load_methods
from remosplat_drake.benchmark.result import read_results
from remosplat_drake.benchmark.suites import PUBLISHED_FOLDERS, default_methods
from remosplat_drake.commands.command_parser import CommandParser
from remosplat_drake.commands.main import main
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.rmmi import write_rmmi

MBM = Path(__file__).resolve().parents[1] / "data" / "mbm"
TOY = """
toy:
  oracle: !GroundTruth {}
  controller: {gains: paper, servo: {max_speed: 0.2}}
"""


@pytest.fixture
def scenes(tmp_path):
    for family, stem in PUBLISHED_FOLDERS.items():
        (tmp_path / stem).mkdir()
        path = tmp_path / stem / f"{stem}_0000.json"
        write_rmmi(path, generate(family, 1))
    return tmp_path


def benchmark(folder, *arguments: str) -> int:
    return main(
        [
            "benchmark",
            "--suite",
            f"published:{folder}",
            "--scenes",
            "1",
            "--output",
            str(folder / "out"),
            "--jobs",
            "0",
            "--scenario-text",
            "{time_limit: 0.2}",
            *arguments,
        ]
    )


def test_ones_own_method_beside_the_papers(scenes, capsys):
    toy = scenes / "toy.yaml"
    toy.write_text(TOY)
    methods = ("--methods", f"sdf-hard,{toy}", "--spheres", "paper")
    assert benchmark(scenes, *methods) == 0
    printed = capsys.readouterr().out
    assert "published scenes: 1 bookshelf, 1 table; paper spheres" in printed
    report = scenes / "out" / "report.md"
    assert report.read_text().strip() == printed.strip()
    path = scenes / "out" / "trials.jsonl"
    results = read_results(path)
    assert {r.method for r in results} == {"sdf-hard", "toy"}
    assert {r.spheres for r in results} == {"paper"}
    before = path.read_bytes()
    assert benchmark(scenes, *methods, "--json") == 0
    assert path.read_bytes() == before
    document = json.loads(capsys.readouterr().out)
    assert document["output"] == str(scenes / "out")
    (comparison,) = document["comparisons"]
    assert [m["method"] for m in comparison["methods"]] == ["sdf-hard", "toy"]


def test_a_terminal_shows_one_table_that_fits(scenes, capsys, monkeypatch):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "80")
    assert benchmark(scenes, "--methods", "sdf-hard") == 0
    shown = Text.from_ansi(capsys.readouterr().out).plain
    assert "sdf-hard" in shown
    assert "|" not in shown
    assert max(map(len, shown.splitlines())) <= 80


def test_guided_control_stands_beside_the_papers_by_default():
    arguments = CommandParser("benchmark").parse_args([])
    chosen = default_methods(arguments.suite).split(",")
    names = [m.name for m in load_methods(chosen)]
    assert {*GROUPS["paper"], "sdf-guided", "ellipsoid-guided"} == {*names}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--methods", "magic"], "unknown method 'magic'"),
        (["--spheres", "none"], "unknown sphere set 'none'"),
        (["--suite", "mine"], "unknown suite 'mine'"),
        (["--scenario-text", "{time: 1}"], "unknown field 'time'"),
    ],
)
def test_mistakes_are_named_in_one_line(scenes, capsys, arguments, message):
    assert benchmark(scenes, *arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""
    assert not (scenes / "out").exists()


def test_a_crash_is_reported_and_ends_with_one(scenes, capsys):
    impossible = "{time_limit: 0.2, wrist_camera: {frame: nowhere}}"
    methods = "--methods", "sdf-hard"
    assert benchmark(scenes, *methods, "--scenario-text", impossible) == 1
    assert "crashed:" in capsys.readouterr().err


def test_a_bad_problem_is_an_error_and_the_rest_goes_on(tmp_path, capsys):
    folder = tmp_path / "shelf_panda"
    shutil.copytree(MBM / "shelf_panda", folder)
    shutil.copy(folder / "scene0001.yaml", folder / "scene0002.yaml")
    (folder / "request0002.yaml").write_text("start_state: {}")
    command = ["benchmark", "--suite", f"mbm:{tmp_path}", "--jobs", "0"]
    command += ["--methods", "sdf-reactive-mbm", "--output"]
    assert main([*command, str(tmp_path / "out")]) == 2
    captured = capsys.readouterr()
    said = [x for x in captured.err.splitlines() if x.startswith("error:")]
    problem = f"{folder / 'request0002.yaml'}:1: start_state.joint_state"
    assert said == [f"error: {problem}: is missing"]
    assert "50.0 [9.5, 90.5] (1/2)" in captured.out
    assert "Neither the map nor the true scene" in captured.out
    # No such folder is no suite.
    command[2] = f"mbm:{tmp_path / 'absent'}"
    assert main([*command, str(tmp_path / "other")]) == 2
    assert "absent: no such folder" in capsys.readouterr().err


@pytest.mark.slow
def test_scenes_get_splats_and_a_stopped_run_goes_on(
    scenes, capsys, monkeypatch
):
    use_cache(monkeypatch, scenes / "cache")
    recipe = "{views: 8, width: 64, height: 48, count: 500}"
    train = ("--methods", "ellipsoid-hard", "--train", "cpu")
    train += ("--recipe", recipe)
    assert benchmark(scenes, *train, "--stop-after", "1e-9") == 3
    stopped = capsys.readouterr().err.split()
    assert "2 trials and 2 splats remain" in " ".join(stopped)
    assert benchmark(scenes, *train) == 0
    report = (scenes / "out" / "report.md").read_text()
    assert "8 views 64 x 48" in report
    results = read_results(scenes / "out" / "trials.jsonl")
    assert {r.splat for r in results} == {"refined"}


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--recipe", "{steps: 3}"), "--recipe: needs --train"),
        (("--train", "cpu", "--train-jobs", "0"), "--train-jobs: must be"),
        (("--train", "cpu", "--ray", "auto"), "--train: cannot go with --ray"),
    ],
)
def test_flags_that_make_no_sense_together(
    scenes, capsys, arguments, complaint
):
    assert benchmark(scenes, *arguments) == 2
    assert complaint in capsys.readouterr().err
