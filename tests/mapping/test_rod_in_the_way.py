"""A robot whose target is in a rod that frames of its live map have shown."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.mapping.map_builder import build_map
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import (
    Box,
    Cylinder,
    PrimitiveScene,
)
from remosplat_drake.signals.scene_map import SceneMap

TARGET = np.array([0.55, 0.0, 0.45])
SCENARIO = f"""
scene: {{unknown: obstacle}}
time_limit: 6
targets: [{{translation: {TARGET.tolist()}, rpy_deg: [180, 0, 0]}}]
controller: {{guidance: {{enabled: false}}}}
"""
CONFIG = MappingConfig(
    volume_lower=[-0.6, -0.8, 0.0], volume_upper=[1.4, 0.8, 1.4], discs=8000
)


def with_rod(diameter: float) -> PrimitiveScene:
    """A rod through the target, a wall behind it, and the floor."""
    leaning = RollPitchYaw(0.03, 0.05, 0.0)
    rod = Cylinder(RigidTransform(leaning, TARGET), diameter / 2, 0.3, "rod")
    wall = Box(RigidTransform([1.2, 0, 0.6]), np.array([0.05, 1.2, 0.6]))
    return PrimitiveScene((wall,), (rod,)).with_floor()


def seen_from_the_robot(scene: PrimitiveScene, share: float) -> Capture:
    """Six frames of the wrist camera's, 0.6 m from the rod.

    They have a share of its pixels in each direction.
    """
    camera = WristCameraConfig()
    turns = np.linspace(-0.6, 0.6, 6)
    back = [np.array([-np.cos(turn), np.sin(turn), 0.2]) for turn in turns]
    return render_capture(
        scene,
        [look_at(TARGET + 0.6 * side, TARGET) for side in back],
        round(share * camera.width),
        round(share * camera.height),
        np.deg2rad(camera.fov_y_deg),
    )


def live_map(capture: Capture, robot: RobotModel) -> SceneMap:
    start = robot.spheres_at(robot.home)
    around = start.radius + CONFIG.start_margin - CONFIG.robot_margin
    return build_map(
        capture,
        CONFIG,
        version=1,
        parent=None,
        frames=tuple(f"frame_{i}" for i in range(len(capture))),
        time=0.0,
        make_field=SphereToEllipsoidField,
        unseen_is_solid=True,
        robot_free=dc.replace(start, radius=around),
    )


@pytest.mark.parametrize(
    ("diameter", "share"),
    [
        (0.006, 0.5),
        pytest.param(0.003, 1.0, marks=pytest.mark.slow),
        pytest.param(0.006, 1.0, marks=pytest.mark.slow),
        pytest.param(0.01, 1.0, marks=pytest.mark.slow),
    ],
)
def test_the_hand_stops_before_a_rod_that_its_target_is_in(diameter, share):
    scenario = load_scenario("PandaReach", SCENARIO)
    robot = load_scenario_robot(scenario)
    scene = with_rod(diameter)
    made = live_map(seen_from_the_robot(scene, share), robot)
    world = World(robot, made.splat_W, scene, made.field, np.array(robot.home))
    result = run(build(scenario, world))
    assert result.outcome != REACHED
    assert "from the rod" in result.motion_status.text
    truth = SignedDistanceField(scene)
    nearest = min(
        truth.clearances(robot.spheres_at(q)).minimum()
        for q in result.trajectory.q
    )
    # It went there, and kept its stopping distance.
    assert 0.015 < nearest < 0.06
