"""Runs at the worst places of a map: who judges them, and one of them."""

import numpy as np
import pytest

from apps.studies.map_bound import closed_loop
from apps.studies.map_bound.case import Case
from apps.studies.map_bound.closed_loop import Aim, Attack
from apps.studies.map_bound.disturbance import EXACT
from apps.studies.map_bound.judge import Sight
from remosplat_drake.capture.rendering.sensor_noise import sensor_noise
from remosplat_drake.robot.robot_model import load_robot

CASE = Case("table", 3, 12, EXACT)


def test_a_robot_within_what_was_seen_is_found_out():
    scene, perfect, capture = CASE.captures()
    sight = Sight(scene, perfect, capture.depth, sensor_noise("none"))
    robot = load_robot("frankie", "paper", 0.0)
    q0 = np.array([*scene.X_WB_start, *robot.home])
    clearance, depth = closed_loop._judged(robot, q0[None], sight)
    assert clearance > 0.05 and depth == 0
    # Driven through the table towards what lies on it.
    ahead = np.linspace(q0[:2], sight.focus_W[:2], 20)
    way = np.array([[*p, *q0[2:]] for p in ahead])
    clearance, depth = closed_loop._judged(robot, way, sight)
    assert clearance < -0.02
    assert 0 < depth <= -clearance


@pytest.mark.slow
def test_an_attack_on_an_exact_map_comes_near_and_touches_nothing():
    (attack,) = closed_loop.attack(Aim(CASE, 1))
    assert not attack.error and attack.depth == 0
    assert attack.clearance > 0 and attack.nearest < 0.5
    assert attack.excess < attack.over < 0.02
    lines = closed_loop.summary([attack, Attack("", error="broken")])
    assert lines[0].startswith("1 runs") and "touches: 0" in lines[1]
