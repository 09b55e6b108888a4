"""The mask against a slow reference, and against rendered robots."""

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.robot_mask import robot_mask
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import KinematicStation

K = np.array([[10.0, 0, 4.0], [0, 11.0, 3.0], [0, 0, 1]])


def reference(spheres, K, X_WC, depth, margin):
    """One pixel and one sphere after the other, in lengths along the ray."""
    hidden = np.zeros(depth.shape, bool)
    for row, column in np.ndindex(*depth.shape):
        ray = np.array(
            [
                (column + 0.5 - K[0, 2]) / K[0, 0],
                (row + 0.5 - K[1, 2]) / K[1, 1],
                1,
            ]
        )
        # Depth is z: a unit along the ray is `length` units of depth.
        length = np.linalg.norm(ray)
        direction_W = X_WC[:3, :3] @ ray / length
        z = depth[row, column]
        for p_WS, r in zip(spheres.p_WS, spheres.radius, strict=True):
            to_S = p_WS - X_WC[:3, 3]
            along = to_S @ direction_W
            aside = np.linalg.norm(to_S - along * direction_W)
            if aside > r + margin:
                continue
            half = np.sqrt((r + margin) ** 2 - aside**2)
            if np.linalg.norm(to_S) > r + margin:
                before = (along - half) / length <= z + margin or z == 0
                hidden[row, column] |= along > 0 and before
            else:
                hidden[row, column] |= z <= (along + half) / length
    return hidden


@settings(max_examples=effort(10, 25))
@given(st.integers(0, 10**6))
def test_the_mask_equals_its_reference(seed):
    rng = np.random.default_rng(seed)
    X_WC = np.eye(4)
    X_WC[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    X_WC[:3, :3] *= np.linalg.det(X_WC[:3, :3])
    X_WC[:3, 3] = rng.normal(size=3)
    p_WS = X_WC[:3, 3] + rng.normal(size=(5, 3))
    spheres = Spheres.at(p_WS, rng.uniform(0.05, 0.9, 5))
    depth = rng.uniform(0, 2, (6, 8)) * (rng.random((6, 8)) > 0.2)
    np.testing.assert_array_equal(
        robot_mask(spheres, K, X_WC, depth, 0.1),
        reference(spheres, K, X_WC, depth, 0.1),
    )


def test_a_sphere_on_the_optical_axis():
    """Its front is at 1.5 m, or 1.4 m inflated; depth 1.3 m is before it."""
    spheres = Spheres.at(np.array([0, 0, 2.0]), 0.5)
    K = np.array([[10.0, 0, 0.5], [0, 10.0, 0.5], [0, 0, 1]])
    depth = np.array([[1.2, 1.35, 1.5, 3.0, 0.0]])
    for z, hidden in zip(depth[0], [0, 1, 1, 1, 1], strict=True):
        one = np.full((1, 1), z)
        assert robot_mask(spheres, K, np.eye(4), one, 0.1) == bool(hidden)
    behind = Spheres.at(np.array([0, 0, -2.0]), 0.5)
    assert not robot_mask(behind, K, np.eye(4), np.ones((1, 1)), 0.1)


def looks_at_robot(robot, config, q, scene):
    """The camera's depth with the robot, and what the scene alone gives."""
    station = MakeSimulatedStation(
        config=KinematicStation(),
        robot=robot,
        scene=scene,
        q0=q,
        wrist_camera=config,
    )
    context = station.CreateDefaultContext()
    port = station.GetOutputPort("wrist_camera.depth")
    depth = port.Eval(context).data[..., 0].copy()
    depth[~np.isfinite(depth)] = 0
    mount = CameraMount(robot, config.hand_eye(), config.frame)
    alone = render_capture(
        scene,
        [RigidTransform(mount.pose(q))],
        config.width,
        config.height,
        np.deg2rad(config.fov_y_deg),
    )
    return depth, alone.depth[0], mount


# Straight ahead, at the fingers, and back at the arm from a stick.
MOUNTS = [
    ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    ([0.0, 0.0, 0.0], [-30.0, 0.0, 0.0]),
    ([0.0, 0.0, 0.5], [180.0, 0.0, 0.0]),
    ([0.3, 0.1, 0.1], [160.0, 30.0, 20.0]),
]


@pytest.mark.parametrize(("translation", "rpy_deg"), MOUNTS)
def test_no_pixel_of_the_robot_survives(frankie, scene, translation, rpy_deg):
    config = WristCameraConfig(
        translation=translation, rpy_deg=rpy_deg, width=160, height=120
    )
    q = np.r_[-0.2, 0.1, 0.3, frankie.home]
    depth, alone, mount = looks_at_robot(frankie, config, q, scene)
    robot = (depth > 0) & ((depth < alone - 1e-3) | (alone == 0))
    hidden = mount.mask(q, config.intrinsics().intrinsic_matrix(), depth)
    assert not (robot & ~hidden).any()
    shown = (depth > 0) & ~robot
    if not any(rpy_deg):
        # Most of the view past the robot is left; at the fingers, whose
        # spheres come within 5 cm of the camera, two thirds are.
        assert (shown & hidden).sum() < 0.1 * shown.sum()
    assert (shown & hidden).sum() < 0.4 * depth.size
    # What is left is the scene, as if there were no robot.
    np.testing.assert_allclose(
        depth[shown & ~hidden], alone[shown & ~hidden], atol=1e-5
    )


@pytest.mark.parametrize(
    ("name", "frame"),
    [
        ("ur5e", "tool0"),
        ("fetch", "gripper_link"),
        ("ridgeback_panda", "wrist_camera"),
        pytest.param("two_pandas", "left_wrist_camera", marks=pytest.mark.slow),
    ],
)
def test_other_robots_are_hidden_by_their_own_shapes(name, frame, scene):
    """From both sides, by a camera on a stick that the hand carries."""
    robot = load_robot(name)
    q = robot.q_home
    X_WF = CameraMount(robot, RigidTransform(), frame).pose(q)
    p_WM = robot.spheres_at(q).p_WS.mean(axis=0)
    for side in (-1.0, 1.0):
        X_WC = look_at(p_WM + np.array([0.9, 1.3 * side, 0.8]), p_WM)
        X_FC = RigidTransform(X_WF).inverse() @ X_WC
        config = WristCameraConfig(
            frame,
            X_FC.translation().tolist(),
            np.rad2deg(RollPitchYaw(X_FC.rotation()).vector()).tolist(),
            width=80,
            height=60,
        )
        depth, alone, mount = looks_at_robot(robot, config, q, scene)
        seen = (depth > 0) & ((depth < alone - 1e-3) | (alone == 0))
        assert seen.mean() > 0.02
        hidden = mount.mask(q, config.intrinsics().intrinsic_matrix(), depth)
        assert not (seen & ~hidden).any()
        assert not hidden.all()


def test_an_unknown_frame_is_named(frankie):
    with pytest.raises(RemoSplatError, match="unknown frame 'elbow_camera'"):
        CameraMount(frankie, RigidTransform(), "elbow_camera")


def test_the_mount_follows_the_hand_eye_transform(frankie):
    q = np.r_[0.5, -0.2, 0.3, frankie.home]
    X_FC = RigidTransform([0.01, 0.02, 0.03])
    X_WF = CameraMount(frankie, RigidTransform()).pose(q)
    X_WC = CameraMount(frankie, X_FC).pose(q)
    np.testing.assert_allclose(X_WC, X_WF @ X_FC.GetAsMatrix4(), atol=1e-12)
