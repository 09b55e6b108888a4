"""The simulated wrist camera as a source of frames."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.camera.rendered_camera import RenderedCamera
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.capture import back_project
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.moving.mover_track import (
    MoverConfig,
    MoverTrack,
    WaypointConfig,
)
from remosplat_drake.scene.primitive_scene import Box

CONFIG = WristCameraConfig(width=64, height=48)
TIME = 12.5


def start(frankie) -> np.ndarray:
    return np.array([0, 0, 0, *frankie.home])


def test_it_measures_the_true_surfaces(frankie, scene):
    camera = RenderedCamera(CONFIG, frankie, scene)
    camera.listen()
    frame = camera.frame(start(frankie), TIME)
    assert frame.time == TIME
    assert frame.rgb.shape == (48, 64, 3)
    p_WS = back_project(frame.K, frame.depth, frame.X_WC)[frame.depth > 0]
    assert len(p_WS) > 500
    distance = SignedDistanceField(scene).clearances(Spheres.at(p_WS)).distance
    np.testing.assert_allclose(distance, 0, atol=3e-3)


def test_its_own_arm_is_hidden(frankie, scene):
    camera = RenderedCamera(CONFIG, frankie, scene)
    frame = camera.frame(start(frankie), TIME)
    assert frame.hidden is not None
    assert not frame.depth[frame.hidden].any()


def test_it_sees_what_has_been_put_there(frankie, scene):
    camera = RenderedCamera(CONFIG, frankie, scene)
    before = camera.frame(start(frankie), TIME)
    p_WP = (before.X_WC @ [0, 0, 0.3, 1])[:3]
    box = Box(RigidTransform(p_WP), np.full(3, 0.05))
    camera.show(dc.replace(scene, boxes=(*scene.boxes, box)))
    after = camera.frame(start(frankie), TIME)
    nearer = (after.depth < before.depth - 0.05) & (after.depth > 0)
    assert nearer.mean() > 0.02


def test_it_sees_what_moves_where_that_is_at_the_time(frankie, scene):
    still = RenderedCamera(CONFIG, frankie, scene).frame(start(frankie), 0.0)
    ahead, behind = (still.X_WC @ [[0, 0], [0, 0], [0.4, -1], [1, 1]])[:3].T
    ball = MoverConfig(
        radius=0.05,
        waypoints=[
            WaypointConfig(0.0, behind.tolist()),
            WaypointConfig(2.0, ahead.tolist()),
        ],
    )
    tracks = [MoverTrack(ball)]
    camera = RenderedCamera(CONFIG, frankie, scene, tracks=tracks)
    before = camera.frame(start(frankie), 0.0)
    np.testing.assert_array_equal(before.depth, still.depth)
    after = camera.frame(start(frankie), 2.0)
    assert after.depth[24, 32] == pytest.approx(0.4 - 0.05, abs=2e-3)
