"""A scenario survives being written out, whatever it consists of."""

import dataclasses as dc

import pytest

from remosplat_drake.errors import RemoSplatError
from remosplat_drake.scenario import LoadScenario, shipped_scenarios
from remosplat_drake.scenario_text import read_scenario_text, scenario_text


@pytest.mark.parametrize("name", shipped_scenarios())
def test_what_is_read_is_what_was_written(name, tmp_path):
    scenario = LoadScenario(name)
    path = tmp_path / "copy.yaml"
    path.write_text(scenario_text(scenario, name))
    again = LoadScenario(f"{path}:{name}")
    assert again == read_scenario_text(path.read_text(), str(path))
    again.source = scenario.source
    assert dc.asdict(again) == dc.asdict(scenario)


def test_relative_files_become_absolute(tmp_path):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    file = folder / "mine.yaml"
    (folder / "scene.json").write_text("{}")
    file.write_text("Mine: {scene: {truth: scene.json}}\n")
    scenario = LoadScenario(str(file))
    text = scenario_text(scenario, "Mine")
    copy = tmp_path / "copy.yaml"
    copy.write_text(text)
    assert LoadScenario(str(copy)).scene.truth == str(folder / "scene.json")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "empty"),
        ("Mine:\n  scene: 3\n", "expected a mapping"),
        ("Mine:\n  time_limit: -1.0\n", "must be positive"),
    ],
)
def test_a_damaged_text_is_an_error_of_the_user(text, problem):
    with pytest.raises(RemoSplatError, match=problem) as caught:
        read_scenario_text(text, "session.json")
    assert str(caught.value).startswith("session.json:")
