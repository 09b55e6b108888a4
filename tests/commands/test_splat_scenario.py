"""`remosplat run scene.ply`: the scenario that is generated for a splat."""

import io
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.commands.splat_scenario import load_given
from remosplat_drake.splat.formats import read_splat, write_splat

SCENES = models_dir() / "scenes"


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """A splat and nothing beside it."""
    return Path(shutil.copy(SCENES / "table/splat.ply", tmp_path / "table.ply"))


def given(
    spec: Path | str, text: str = "", save: Path | None = None
) -> tuple[Any, str]:
    """The scenario, and what was said."""
    stream = io.StringIO()
    console = Console(file=stream, width=10_000)
    scenario = load_given(str(spec), text, console, save)
    return scenario, stream.getvalue()


def test_a_free_start_and_a_target_are_found_and_told(table):
    scenario, said = given(table, "{time_limit: 7}")
    assert scenario.time_limit == 7
    (target,) = scenario.targets
    world = load_world(scenario)
    start = world.field.clearances(world.robot.spheres_at(world.q0))
    assert start.minimum() >= 0.15
    x, y, z = target.translation
    assert f"with a target at ({x:.2f}, {y:.2f}, {z:.2f}) m" in said
    assert f"`remosplat run {table} --save-scenario table.yaml`" in said
    assert (
        "the space that the cameras of this splat have seen is unknown" in said
    )
    assert said.count("\n") == 2


@pytest.mark.parametrize("text", ["", "{time_limit: 7, seed: 3}"])
def test_what_was_made_up_is_kept_and_found_again(table, text):
    kept = table.with_suffix(".yaml")
    made, said = given(table, text, save=kept)
    assert f"it is in {kept}" in said
    again = load_scenario(str(kept))
    assert again.targets == made.targets
    assert again.robot.base_pose == made.robot.base_pose
    assert (again.time_limit, again.seed) == (made.time_limit, made.seed)
    found, said = given(table)
    assert f"{kept}, which is beside the splat" in said
    assert found.targets == made.targets


def test_an_unrelated_scenario_beside_it_is_not_taken(table):
    other = "Other: {scene: {splat: other.ply}, targets: [{}]}"
    table.with_suffix(".yaml").write_text(other)
    _, said = given(table)
    assert "with a target at" in said


def test_a_fixed_arm_reaches_for_what_is_on_its_table():
    splat = SCENES / "workbench/splat.ply"
    scenario, said = given(splat, "{robot: {model: panda}}")
    assert "panda starts at the origin" in said
    assert scenario.robot.base_pose is None
    assert scenario.targets[0].translation[2] < 0.35


def test_with_targets_of_ones_own_nothing_is_made_up(table):
    text = "{targets: [{translation: [1, 0, 0.9]}]}"
    scenario, said = given(table, text)
    assert said == ""
    assert scenario.targets[0].translation == [1, 0, 0.9]


def test_a_moved_splat_is_looked_at_where_it_lies(table):
    still, _ = given(table)
    moved, _ = given(table, "{scene: {X_WG: {translation: [5, 0, 0]}}}")
    shift = np.subtract(
        moved.targets[0].translation, still.targets[0].translation
    )
    assert 4 < shift[0] < 6


def test_what_lies_below_the_floor_is_refused(table):
    text = "{scene: {X_WG: {rpy_deg: [90, 0, 0]}}}"
    with pytest.raises(RemoSplatError) as caught:
        given(table, text)
    assert "% of the splat lies below the floor; z must be up" in str(
        caught.value
    )


def test_a_scene_without_a_place_is_refused_in_one_line(tmp_path, capsys):
    splat = read_splat(SCENES / "table/splat.ply")
    crumbs = splat.select(np.arange(len(splat)) < 50)
    write_splat(tmp_path / "crumbs.ply", crumbs)
    path = str(tmp_path / "crumbs.ply")
    assert main(["run", path, "--headless"]) == USER_ERROR
    error = capsys.readouterr().err
    assert "no scenario given, and none can be generated: found no" in error
    assert error.count("\n") == 1


def test_only_what_was_made_up_is_saved(tmp_path, capsys):
    flags = ["--save-scenario", str(tmp_path / "a.yaml")]
    assert main(["run", "TableReach", *flags]) == USER_ERROR
    assert (
        "--save-scenario: has an effect only for a splat"
        in capsys.readouterr().err
    )
    assert not list(tmp_path.iterdir())


def test_nothing_is_made_up_for_a_real_robot(table, capsys):
    words = ["run", str(table), "--hardware", "--rehearsal"]
    assert main(words) == USER_ERROR
    assert "not a splat" in capsys.readouterr().err


def test_inspect_looks_into_a_splat(table, tmp_path, capsys):
    picture = tmp_path / "views.png"
    assert main(["inspect", str(table), "--output", str(picture)]) == 0
    assert "no scenario given: frankie starts" in capsys.readouterr().err
    assert picture.is_file()
