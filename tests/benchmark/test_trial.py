"""One trial: how it is judged, and what its key depends on."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.benchmark import trial as trial_module
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.reaching_task import SURFEL
from remosplat_drake.benchmark.result import (
    COLLISION,
    LOCAL_MINIMUM,
    SUCCESS,
    TIMEOUT,
)
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi

ROBOT = load_robot("frankie", "paper", 0.03)
HOME = np.array([0.0, 0.0, 0.0, *ROBOT.home])


def post_scene(x: float, y: float = 0.0, ahead: float = 0.3) -> PrimitiveScene:
    """A post, and a target `ahead` of where the hand starts."""
    X_WE = ROBOT.end_effector_pose(HOME).copy()
    X_WE[0, 3] += ahead
    return PrimitiveScene(
        cylinders=(Cylinder(RigidTransform([x, y, 0.6]), 0.03, 0.6),),
        X_WE_target=RigidTransform(X_WE),
        X_WB_start=(0.0, 0.0, 0.0),
    )


def run_in(scene: PrimitiveScene, folder, method: str, text: str = ""):
    path = folder / "scene.json"
    write_rmmi(path, scene)
    (loaded,) = load_methods([method], text, "paper")
    return run_trial(Trial(loaded, SceneCase("post", "table", file=str(path))))


def test_a_free_way_is_a_success(tmp_path):
    result = run_in(post_scene(0.5, 2.0), tmp_path, "sdf-active")
    text, authors = result.text, result.authors
    assert (text.outcome, authors.outcome) == (SUCCESS, SUCCESS)
    # The text accepts 2 cm of straight distance, L1 is never smaller.
    assert text.duration <= authors.duration < 5
    assert 0.27 < text.path_length <= authors.path_length < 0.4
    assert text.minimum_distance > 1
    assert result.times.tick_p99 >= result.times.tick_p50 > 0
    assert result.splat == "none"


def test_too_little_time_is_a_timeout(tmp_path):
    scene = post_scene(0.5, 2.0, ahead=2.0)
    result = run_in(scene, tmp_path, "sdf-active", "{time_limit: 1}")
    assert result.outcome("text") == TIMEOUT
    assert result.text.duration == pytest.approx(1.0)


def test_a_post_in_the_way_is_a_local_minimum(tmp_path):
    hand = ROBOT.end_effector_pose(HOME)[0, 3]
    scene = post_scene(hand + 0.35, ahead=0.7)
    result = run_in(scene, tmp_path, "sdf-hard", "{time_limit: 8}")
    assert result.outcome("text") == LOCAL_MINIMUM
    assert result.text.minimum_distance > 0


def test_a_controller_that_ignores_the_scene_collides(tmp_path):
    hand = ROBOT.end_effector_pose(HOME)[0, 3]
    scene = post_scene(hand + 0.2, ahead=0.5)
    blind = "{controller: {collision: {influence: 1e-6, stopping: 0}}}"
    result = run_in(scene, tmp_path, "sdf-hard", blind)
    assert result.outcome("text") == result.outcome("authors") == COLLISION
    assert result.text.minimum_distance < 0


def test_without_a_trained_splat_surfels_stand_in(tmp_path, monkeypatch):
    path = tmp_path / "scene.json"
    write_rmmi(path, post_scene(0.5, 1.0))
    (method,) = load_methods(["ellipsoid-active"], "{time_limit: 0.1}")
    result = run_trial(
        Trial(method, SceneCase("post", "table", file=str(path)))
    )
    assert result.splat == SURFEL
    assert 50_000 < result.splat_count < 70_000


def test_the_key_names_method_scene_and_seed(trials):
    first, second = trials
    keys = [
        first.key(),
        second.key(),
        dc.replace(first, seed=1).key(),
        dc.replace(
            first, method=load_methods(["sdf-active"], "{time_limit: 1}")[0]
        ).key(),
    ]
    assert len(set(keys)) == 4
    assert first.key() == dc.replace(first).key()


def test_a_new_trial_version_is_another_key(trials, monkeypatch):
    before = trials[0].key()
    monkeypatch.setattr(trial_module, "TRIAL_VERSION", -1)
    assert trials[0].key() != before
