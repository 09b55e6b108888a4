"""A scenario survives being written out, whatever it consists of."""

import dataclasses as dc

import pytest

from remosplat_drake.app.scenario import load_scenario, shipped_scenarios
from remosplat_drake.app.scenario_text import scenario_text


@pytest.mark.parametrize("name", shipped_scenarios())
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
