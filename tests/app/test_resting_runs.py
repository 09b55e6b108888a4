"""A robot that holds a reached target stands still."""

import numpy as np
from effort import effort
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi

DT = 0.05


def held(tmp_path, robot, seconds: float, text: str = "") -> np.ndarray:
    """Where a robot is whose target is where it stands: q of every tick."""
    box = Box(RigidTransform([0.9, 0.5, 0.5]), np.array([0.1, 0.3, 0.8]))
    X_WT = RigidTransform(robot.end_effector_pose(robot.q_home))
    scene = PrimitiveScene(boxes=(box,), X_WE_target=X_WT)
    write_rmmi(tmp_path / "scene.json", scene)
    (tmp_path / "test.yaml").write_text(
        "Test:\n"
        "  scene: {truth: scene.json}\n"
        "  oracle: !GroundTruth {}\n"
        f"  control_period: {DT}\n"
        f"  time_limit: {seconds}\n" + text
    )
    scenario = load_scenario(f"{tmp_path}/test.yaml")
    application = build(scenario, load_world(scenario))
    return run(application, until=lambda error: False).trajectory.q


def moved(q: np.ndarray) -> float:
    """How far the robot has been from where it began [m, rad]."""
    return float(np.abs(q - q[0]).max())


def test_a_held_target_is_held_still(frankie, tmp_path):
    q = held(tmp_path, frankie, effort(10.0, 30.0))
    settled = round(3.0 / DT)
    assert moved(q[:settled]) > 0  # It settles first.
    np.testing.assert_array_equal(
        q[settled:], q[settled:][:1].repeat(len(q) - settled, 0)
    )


def test_self_motion_can_be_had(frankie, tmp_path):
    rest = "  controller: {rest: {enabled: false}}\n"
    q = held(tmp_path, frankie, effort(10.0, 30.0), rest)
    assert moved(q[round(3.0 / DT) :]) > 0.01
