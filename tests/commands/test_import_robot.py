"""`remosplat import-robot`: one command from a URDF to a run that reaches."""

import re

import numpy as np
import pytest

pytest.importorskip("trimesh")

from model_sources import real_robots
from runs import PROGRESS
from toy_robot import toy_urdf, write_toy

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.base import progress
from remosplat_drake.commands.main import USER_ERROR, main

COARSE = ["--tolerance", "40"]


def test_what_is_written_is_run_and_reaches(tmp_path, capsys):
    source, out = write_toy(tmp_path), tmp_path / "made"
    assert main(["import-robot", str(source), "--out", str(out), *COARSE]) == 0
    said = capsys.readouterr().out
    for text in ("found", "guessed", f"remosplat run {out}/scenario.yaml"):
        assert text in said
    names = {path.name for path in out.iterdir()}
    assert names >= {
        "toy.urdf",
        "toy.yaml",
        "spheres.yaml",
        "scenario.yaml",
        "scene.ply",
        "scene.json",
        "meshes",
    }
    result = run(build(load_scenario(str(out / "scenario.yaml"))))
    assert result.outcome == "reached"
    assert result.targets >= 1
    assert result.metrics.truth_clearance_min > 0
    # Nothing else is left behind.
    assert {path.name for path in tmp_path.iterdir()} == {
        "toy_description",
        "made",
    }


def test_a_picture_shows_the_robot_and_its_spheres(rendering, three_link):
    from remosplat_drake.capture.rendering.robot_picture import (
        SIZE,
        draw_robot,
    )

    picture = draw_robot(three_link, three_link.q_home)
    assert picture.shape == (SIZE, 2 * SIZE, 3)
    for half in (picture[:, :SIZE], picture[:, SIZE:]):
        background = half[0, 0].astype(int)
        seen = (np.abs(half - background).sum(axis=2) > 30).mean()
        # It fills a part of the picture, and is not cut off.
        assert 0.02 < seen < 0.7
        border = np.concatenate([half[0], half[-1], half[:, 0], half[:, -1]])
        assert (np.abs(border - background).sum(axis=1) < 30).all()


@pytest.mark.slow
def test_a_pipe_hears_how_far_it_is(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(progress, "BEGUN", 0.001)
    monkeypatch.setattr(progress, "PERIOD", 0.001)
    source, out = write_toy(tmp_path), tmp_path / "made"
    flags = ["--no-scenario", "--out", str(out), *COARSE]
    assert main(["import-robot", str(source), *flags]) == 0
    said = capsys.readouterr()
    lines = said.err.splitlines()
    assert all(re.match(PROGRESS, line) for line in lines)
    assert {"reading", "fitting spheres"} <= {
        line.partition(":")[0] for line in lines
    }
    assert "reading" not in said.out


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--end-effector", "tool"], "unknown link 'tool' (did you mean"),
        (["--package", "x"], "--package: x: expected NAME=DIR"),
        (["--arg", "x"], "--arg: x: expected NAME=VALUE"),
        (["--tolerance", "0"], "--tolerance: expected 0.5 to 200"),
        (["--base", "omnidirectional"], "unknown choice 'omnidirectional'"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(
    tmp_path, capsys, flags, message
):
    source, out = write_toy(tmp_path), tmp_path / "made"
    command = ["import-robot", str(source), "--out", str(out), *flags]
    assert main(command) == USER_ERROR
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"toy_description"}


def test_broken_xml_is_one_line_and_leaves_nothing(tmp_path, capsys):
    source = write_toy(tmp_path, toy_urdf()[:-5])
    out = tmp_path / "made"
    assert main(["import-robot", str(source), "--out", str(out)]) == USER_ERROR
    assert "toy.urdf: is broken XML" in capsys.readouterr().err
    assert not out.exists()


def test_a_folder_that_is_there_is_left_alone(tmp_path, capsys):
    source = write_toy(tmp_path)
    assert (
        main(["import-robot", str(source), "--out", str(tmp_path)])
        == USER_ERROR
    )
    assert "exists already" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    "file",
    [
        "ur_description/urdf/ur5_robot.urdf",
        "z1_description/urdf/z1.urdf",
        "tiago_description/robots/tiago_no_hand.urdf",
    ],
)
def test_a_real_robot_is_imported_and_reaches(tmp_path, file):
    robots = real_robots()
    if robots is None:
        pytest.skip("needs the package example-robot-data")
    out = tmp_path / "made"
    assert main(["import-robot", str(robots / file), "--out", str(out)]) == 0
    result = run(build(load_scenario(str(out / "scenario.yaml"))))
    assert result.outcome == "reached"
