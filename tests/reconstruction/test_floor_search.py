"""The floor is found however the capture's frame lies, or not at all."""

import dataclasses as dc
import json

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.reconstruction.floor import FloorConfig, find_floor
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene


def moved(capture: Capture, X_VW: RigidTransform) -> Capture:
    """The capture as if its world frame were V."""
    return dc.replace(capture, X_WC=X_VW.GetAsMatrix4() @ capture.X_WC)


@pytest.mark.parametrize("seed", range(4))
def test_a_turned_capture_is_set_upright(scene_capture, seed):
    rng = np.random.default_rng(seed)
    rpy = rng.uniform([-np.pi, -1, -np.pi], [np.pi, 1, np.pi])
    X_VW = RigidTransform(RollPitchYaw(rpy), rng.uniform(-2, 2, 3))
    turned = moved(scene_capture, X_VW)
    floor = find_floor(turned)
    X_FW = floor.X_FW @ X_VW
    # Up is up and the floor is z = 0; yaw and origin are the capture's own.
    assert X_FW.rotation().matrix()[2, 2] > np.cos(1e-3)
    assert abs(X_FW.translation()[2]) < 1e-3
    assert floor.area > 1 and floor.rms < 1e-3
    x_FV = floor.X_FW.rotation().matrix()[:, 0]
    assert abs(x_FV[1]) < 1e-9
    aligned = floor.aligned(turned)
    np.testing.assert_allclose(
        aligned.X_WC[:, 2, 3], scene_capture.X_WC[:, 2, 3], atol=5e-3
    )


def test_a_level_capture_stays_as_it_is(scene_capture):
    X_FW = find_floor(scene_capture).X_FW
    assert X_FW.IsNearlyEqualTo(RigidTransform(), 1e-3)


def test_same_seed_same_floor(scene_capture):
    floors = [find_floor(scene_capture, FloorConfig(seed=3)) for _ in "ab"]
    assert floors[0].X_FW.IsExactlyEqualTo(floors[1].X_FW)


def poses_around(height: float) -> list[RigidTransform]:
    """Four cameras that look at the origin from a height."""
    return [
        look_at(np.array([x, y, height]), np.zeros(3))
        for x, y in ((1, 0.2), (0.2, 1), (-1, 0.1), (0.1, -1))
    ]


def test_a_small_plate_is_no_floor():
    plate = Box(RigidTransform(), np.array([0.2, 0.2, 0.01]))
    capture = render_capture(
        PrimitiveScene(boxes=(plate,)), poses_around(0.8), 120, 90
    )
    with pytest.raises(RemoSplatError, match="is only 0"):
        find_floor(capture)


def test_a_shelf_with_things_beneath_is_no_floor():
    """The ground beneath it is too steep for a floor."""
    shelf = Box(RigidTransform(), np.array([0.4, 0.4, 0.01]))
    slope = Box(
        RigidTransform(RollPitchYaw(1.2, 0, 0), [0, 0, -0.5]),
        np.array([2.0, 2, 0.01]),
    )
    scene = PrimitiveScene(boxes=(shelf, slope))
    capture = render_capture(scene, poses_around(1.2), 120, 90)
    with pytest.raises(RemoSplatError, match="beneath"):
        find_floor(capture)


@pytest.mark.shared_data
def test_the_kitchen_floor(shared_data):
    """Against the frame that the data folder gives, found by other means."""
    folder = shared_data / "redkitchen"
    capture = read_capture(folder / "capture")
    # Every fourth view is enough, and quicker.
    floor = find_floor(capture.select(np.arange(0, len(capture), 4)))
    given = json.loads((folder / "scene_frame.json").read_text())
    up_W = floor.X_FW.rotation().matrix()[2]
    assert up_W @ given["up_in_world"] > np.cos(np.radians(1))
    # Where the table stands, its height over our floor is its height.
    T = np.array(given["T_gravity_from_world"])
    p_WT = np.linalg.inv(T) @ [0, 0, given["table_height_m"], 1]
    height = (floor.X_FW @ p_WT[:3])[2]
    assert height == pytest.approx(given["table_height_m"], abs=0.03)
