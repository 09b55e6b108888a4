"""A scenario for two arms, from its file to the numbers of its run."""

from pathlib import Path

import pytest

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import scenario_targets
from remosplat_drake.base.errors import FieldError

ROBOT = Path(__file__).parents[1] / "data" / "two_arms.yaml"
EFFECTORS = ("left", "right")

TEXT = """
Both:
  robot: {{model: {robot}}}
  targets:
  - {{effector: right, translation: [1, 0, 0]{how}}}
  - {{translation: [2, 0, 0], free: [rx, ry, rz]}}
  - {{effector: {last}, translation: [3, 0, 0]}}
"""


def load(folder, last: str = "right", how: str = ""):
    file = folder / "both.yaml"
    file.write_text(TEXT.format(robot=ROBOT, last=last, how=how))
    return load_scenario(str(file))


def test_each_end_effector_has_its_own_targets(tmp_path):
    scenario = load(tmp_path, how=", pass_within: 0.1")
    found = scenario_targets(scenario, None, EFFECTORS)
    assert [t.X_WT[0, 3] for t in found["left"]] == [2]
    assert [t.X_WT[0, 3] for t in found["right"]] == [1, 3]


def test_who_is_not_there_is_named(tmp_path):
    scenario = load(tmp_path, "middle")
    with pytest.raises(FieldError) as caught:
        scenario_targets(scenario, None, EFFECTORS)
    assert caught.value.field == "targets[2].effector"
    assert "'middle'" in caught.value.problem
    assert "left" in caught.value.problem


def test_the_last_of_each_is_held(tmp_path):
    with pytest.raises(FieldError) as caught:
        load(tmp_path, "left", ", pass_within: 0.1")
    assert caught.value.field == "targets[0].pass_within"
