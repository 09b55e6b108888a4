"""Runs at the worst places of a map: their evaluation, and one of them."""

import dataclasses as dc
import json

import numpy as np
import pytest

from apps.studies.attacks import Aim, Attacks, Places, restored, summary
from apps.studies.map_bound.case import Case
from apps.studies.map_bound.closed_loop import SceneTruth, attack_case
from apps.studies.map_bound.disturbance import EXACT
from apps.studies.map_bound.judge import Sight
from remosplat_drake.capture.rendering.sensor_noise import sensor_noise
from remosplat_drake.robot.robot_model import load_robot

CASE = Case("table", 3, 12, EXACT)


def test_a_robot_within_what_was_seen_is_found_out():
    scene, perfect, capture = CASE.captures()
    sight = Sight(scene, perfect, capture.depth, sensor_noise("none"))
    truth = SceneTruth(sight)
    robot = load_robot("frankie", "paper", 0.0)
    q0 = np.array([*scene.X_WB_start, *robot.home])
    clearance, depth = truth.judged(robot, q0[None])
    assert clearance > 0.05 and depth == 0
    # Driven through the table towards what lies on it.
    ahead = np.linspace(q0[:2], sight.focus_W[:2], 20)
    way = np.array([[*p, *q0[2:]] for p in ahead])
    clearance, depth = truth.judged(robot, way)
    assert clearance < -0.02
    assert 0 < depth <= -clearance


def test_worst_places_are_apart_and_can_be_got_to():
    p_W = np.array([[0, 0, 1], [0.05, 0, 1], [0.3, 0, 1], [0, 2, 1.0]])
    inward_W = np.array([[1, 0, 0], [1, 0, 0], [-1, 0, 0], [1, 0, 0.0]])
    excess = np.array([1e-3, 2e-3, 3e-3, 4e-3])
    places = Places(p_W, inward_W, excess, excess)
    assert places.worst(9) == [3, 2, 1]
    assert places.worst(1) == [3]
    # From x < 0: one is approached from behind, one is too far away.
    near = places.reachable(np.array([-1.0, 0, 0]), np.array([0, 0, 1.0]))
    assert near.excess.tolist() == [1e-3, 2e-3]
    X_WE = places.X_WE(2)
    assert np.allclose(X_WE[:3, :3] @ X_WE[:3, :3].T, np.eye(3))
    assert np.linalg.det(X_WE[:3, :3]) == pytest.approx(1)
    assert X_WE[:3, 2].tolist() == [-1, 0, 0]


@pytest.mark.slow
def test_an_attack_on_an_exact_map_comes_near_and_touches_nothing():
    result = attack_case(Aim(CASE, 1))
    (run,) = result.runs
    assert not result.error and run.depth == 0
    assert run.clearance > 0 and run.nearest < 0.5
    assert run.excess < run.over < 0.02
    assert restored(json.loads(json.dumps(dc.asdict(result)))) == result
    lines = summary([result, Attacks("other", error="broken")])
    assert lines[:2] == [
        "1 runs aimed at the worst places of maps",
        "other: broken",
    ]
    assert "touches: 0" in lines[2]
