"""A scenario survives being written out, with any content."""

import dataclasses as dc

import pytest
from effort import effort

from remosplat_drake.app.scenario import load_scenario, shipped_scenarios
from remosplat_drake.app.scenario_text import scenario_text


@pytest.mark.parametrize("name", list(shipped_scenarios())[:: effort(4, 1)])
def test_what_is_read_is_what_was_written(name, tmp_path):
    scenario = load_scenario(name)
    path = tmp_path / "copy.yaml"
    path.write_text(scenario_text(scenario, name))
    again = load_scenario(f"{path}:{name}")
    again.source = scenario.source
    assert dc.asdict(again) == dc.asdict(scenario)


def test_relative_files_become_absolute(tmp_path):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    file = folder / "mine.yaml"
    (folder / "scene.json").write_text("{}")
    file.write_text("Mine: {scene: {truth: scene.json}}\n")
    scenario = load_scenario(str(file))
    text = scenario_text(scenario, "Mine")
    copy = tmp_path / "copy.yaml"
    copy.write_text(text)
    assert load_scenario(str(copy)).scene.truth == str(folder / "scene.json")


def test_models_of_directives_are_found_from_everywhere(tmp_path):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "box.sdf").write_text("<sdf/>")
    (folder / "mine.yaml").write_text(
        "Mine: {scene: {directives: ["
        "{add_model: {name: a, file: box.sdf}},"
        "{add_model: {name: b, file: package://drake_models/box.sdf}},"
        "{add_weld: {parent: world, child: a::body}}]}}"
    )
    scenario = load_scenario(str(folder / "mine.yaml"))
    copy = tmp_path / "copy.yaml"
    copy.write_text(scenario_text(scenario, "Mine"))
    near, far, weld = load_scenario(str(copy)).scene.directives
    assert near.add_model.file == f"file://{folder}/box.sdf"
    assert far.add_model.file == "package://drake_models/box.sdf"
    assert (weld.add_weld.parent, weld.add_model) == ("world", None)
    before = scenario.scene.directives[0].add_model
    assert before is not None
    assert before.file == "box.sdf"
