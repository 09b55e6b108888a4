"""The robot of a scenario: a name, or a file beside the scenario."""

import shutil
from pathlib import Path

import pytest

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_robot import (
    load_scenario_robot,
    robot_beside,
    robot_file,
)
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.base.errors import FieldError

DATA = Path(__file__).resolve().parents[1] / "data"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scenario, and in a folder beside it the robot that it names."""
    folder = tmp_path / "mine"
    (folder / "arm").mkdir(parents=True)
    for file in DATA.glob("three_link*"):
        shutil.copy(file, folder / "arm")
    text = "Reach: {robot: {model: arm/three_link.yaml}}\n"
    (folder / "reach.yaml").write_text(text)
    return folder


def test_a_robots_file_is_relative_to_the_scenarios(
    folder, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    scenario = load_scenario("mine/reach.yaml")
    assert Path(robot_file(scenario)) == Path("mine/arm/three_link.yaml")
    assert load_scenario_robot(scenario).description.name == "three_link"


def test_a_robot_that_is_typed_may_be_in_the_working_directory(
    folder, monkeypatch
):
    monkeypatch.chdir(folder / "arm")
    typed = "{robot: {model: three_link.yaml}}"
    scenario = load_scenario("TableReach", typed)
    assert load_scenario_robot(scenario).description.name == "three_link"


def test_beside_the_scenario_comes_first(folder, monkeypatch):
    other = folder / "other"
    shutil.copytree(folder / "arm", other / "arm")
    monkeypatch.chdir(other)
    scenario = load_scenario(str(folder / "reach.yaml"))
    assert Path(robot_file(scenario)) == folder / "arm/three_link.yaml"


def test_a_shipped_robot_has_a_name(folder):
    scenario = load_scenario(
        str(folder / "reach.yaml"), "{robot: {model: panda}}"
    )
    assert robot_file(scenario) == "panda"


def test_a_robot_that_is_not_there_is_told_with_its_field(folder):
    file = folder / "reach.yaml"
    file.write_text("Reach: {robot: {model: arm/three_links.yaml}}\n")
    with pytest.raises(
        FieldError,
        match=r"reach\.yaml:Reach: robot\.model: arm/three_links\.yaml: no such"
        r" file \(did you mean 'three_link.yaml'\?\)",
    ):
        load_scenario_robot(load_scenario(str(file)))


def test_a_model_in_its_place_is_told_how_to_be_imported(folder):
    file = folder / "reach.yaml"
    file.write_text("Reach: {robot: {model: fetch.urdf}}\n")
    with pytest.raises(
        FieldError,
        match=r"reach\.yaml:Reach: robot\.model: fetch\.urdf: is a model, not a"
        r" robot description; run `remosplat import-robot fetch\.urdf`, and"
        r" name fetch/NAME\.yaml in its place",
    ):
        load_scenario_robot(load_scenario(str(file)))


@pytest.mark.parametrize(
    ("old", "field"),
    [
        ("three_link.urdf", "model"),
        ("three_link_spheres.yaml", "spheres.covering"),
    ],
)
def test_a_file_that_a_description_lacks_is_told_with_its_field(
    folder, old, field
):
    (folder / "arm" / old).unlink()
    scenario = load_scenario(str(folder / "reach.yaml"))
    with pytest.raises(
        FieldError, match=f"three_link.yaml: {field}: {old}: no"
    ):
        load_scenario_robot(scenario)


def test_a_written_scenario_finds_its_robot_from_everywhere(folder, tmp_path):
    scenario = load_scenario(str(folder / "reach.yaml"))
    copy = tmp_path / "copy.yaml"
    copy.write_text(scenario_text(scenario, "Reach"))
    again = load_scenario(str(copy))
    assert again.robot.model == str(folder / "arm/three_link.yaml")


def test_a_robot_within_a_folder_is_named_relative_to_it(folder):
    file = str(folder / "arm/three_link.yaml")
    assert robot_beside(file, folder) == "arm/three_link.yaml"
    assert robot_beside(file, folder / "elsewhere") == file
    assert robot_beside("panda", folder) == "panda"
