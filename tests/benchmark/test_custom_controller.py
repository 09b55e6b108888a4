"""One's own controller, beside the shipped methods."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.result import SUCCESS
from remosplat_drake.benchmark.runner import run_trials
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))


@pytest.fixture
def case(tmp_path) -> SceneCase:
    """A post far away, and a target 30 cm ahead of the hand."""
    robot = load_robot("frankie", "paper", 0.03)
    X_WE = robot.end_effector_pose(np.array([0.0, 0.0, 0.0, *robot.home]))
    X_WE[0, 3] += 0.3
    scene = PrimitiveScene(
        cylinders=(Cylinder(RigidTransform([0.5, 2, 0.6]), 0.03, 0.6),),
        X_WE_target=RigidTransform(X_WE),
        X_WB_start=(0.0, 0.0, 0.0),
    )
    write_rmmi(tmp_path / "scene.json", scene)
    return SceneCase("free", "table", file=str(tmp_path / "scene.json"))


def test_a_toy_reaches_a_free_target(case):
    (method,) = load_methods(["toy_controller:make"], spheres="paper")
    result = run_trial(Trial(method, case))
    assert result.method == "toy_controller:make"
    assert result.gains == "own"
    assert result.outcome("text") == result.outcome("authors") == SUCCESS
    assert result.text.duration < 5
    assert result.times.tick_p50 > 0


def test_it_takes_the_oracle_of_a_method():
    names = ["sdf-hard", "toy_controller:make:ellipsoid-hard"]
    ours, own = load_methods(names)
    assert not ours.needs_splat
    assert own.needs_splat
    assert own.name == names[1]
    assert own.fingerprint != load_methods(["ellipsoid-hard"])[0].fingerprint


@pytest.mark.parametrize(
    ("function", "message"),
    [("make_too_fast", "2.00 times"), ("make_shapeless", "9 finite numbers")],
)
def test_an_unusable_command_is_a_recorded_crash(
    case, tmp_path, function, message
):
    (method,) = load_methods([f"toy_controller:{function}"])
    trial = Trial(method, case)
    (result,) = run_trials([trial], tmp_path / "x.jsonl", jobs=0)
    assert message in result.error


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("no_such_module:make", "", "No module named"),
        ("toy_controller:other", "", "has no 'other'"),
        ("toy_controller:make:magic", "", "unknown method 'magic'"),
        ("toy_controller:make", "{station: !DynamicStation {}}", "kinematic"),
    ],
)
def test_what_cannot_be_loaded_is_named(name, text, message):
    with pytest.raises(RemoSplatError, match=message):
        load_methods([name], text)
