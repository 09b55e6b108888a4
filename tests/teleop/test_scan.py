"""The views of a scan, worked by hand, and what the real robot sees of it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from operated import Operated
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.signals.target_state import HOLD
from remosplat_drake.teleop.scan import heading, scan_poses, upright_camera
from remosplat_drake.teleop.teleop_config import ScanConfig, TeleopConfig

CONFIG = ScanConfig(pan_deg=40, steep_deg=60, flat_deg=20)
# A camera 0.1 m beside the end effector.
X_EC = RigidTransform(RollPitchYaw(0, 0, 0.5), [0.1, 0, 0]).GetAsMatrix4()


def looking(yaw: float, pitch: float) -> np.ndarray:
    """An end effector whose camera looks so from (1, 2, 3)."""
    X_WC = np.eye(4)
    X_WC[:3, :3] = upright_camera(yaw, pitch)
    X_WC[:3, 3] = 1, 2, 3
    return X_WC @ np.linalg.inv(X_EC)


def views(X_WE: np.ndarray, count: int) -> list[np.ndarray]:
    return [X @ X_EC for X in scan_poses(X_WE, X_EC, count, CONFIG)]


def yaw_and_pitch(X_WC: np.ndarray) -> tuple[float, float]:
    z = X_WC[:3, 2]
    angles = np.arctan2(z[1], z[0]), np.arcsin(-z[2])
    yaw, pitch = np.degrees(angles)
    return round(yaw, 6), round(pitch, 6)


def test_a_camera_upright_by_hand():
    # Looking along x: the image's right is -y, its bottom is -z.
    expected = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    np.testing.assert_allclose(upright_camera(0, 0), expected, atol=1e-15)
    # Looking down: its bottom is towards the operator.
    expected = np.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1]])
    np.testing.assert_allclose(
        upright_camera(0, np.pi / 2), expected, atol=1e-15
    )


@given(st.floats(-3, 3), st.floats(-0.7, 1.57))
def test_the_heading_is_where_the_camera_looks_on_the_map(yaw, pitch):
    R_WC = upright_camera(yaw, pitch)
    np.testing.assert_allclose(R_WC @ R_WC.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R_WC) > 0
    assert heading(R_WC) == pytest.approx(yaw)


def test_two_rows_there_and_back():
    directions = [yaw_and_pitch(X) for X in views(looking(0, np.pi / 2), 5)]
    assert directions == [
        (40, 60),
        (-40, 60),
        (-40, 20),
        (0, 20),
        (40, 20),
    ]


@pytest.mark.parametrize(
    ("count", "pans"), [(1, [0]), (2, [40, -40]), (3, [40, 0, -40])]
)
def test_few_views_lie_in_one_row(count, pans):
    directions = [yaw_and_pitch(X) for X in views(looking(0, 1), count)]
    assert directions == [(pan, 40) for pan in pans]


@given(st.integers(1, 30), st.floats(-3, 3))
def test_the_camera_stays_in_its_place(count, yaw):
    X_WE = looking(yaw, 1.0)
    poses = scan_poses(X_WE, X_EC, count, CONFIG)
    assert len(poses) == count
    for X in poses:
        np.testing.assert_allclose((X @ X_EC)[:3, 3], [1, 2, 3], atol=1e-12)
        assert np.linalg.norm(X[:3, 3] - X_WE[:3, 3]) <= 0.2 + 1e-12


@pytest.mark.slow
def test_frankie_scans_the_table():
    """All views are reached, far from everything, and show more than one."""
    operated = Operated("TableReach", TeleopConfig())
    start = operated.mount.pose(operated.q)[:3, 3]
    operated.wait(0.02)
    operated.say(scans=1)
    operated.wait(0.05)
    X_EC = operated.law.X_EC
    views = [X_WE @ X_EC for X_WE in operated.state.scan]
    taken, clearance = [], np.inf
    while operated.context.get_time() < 30:
        operated.wait(0.05)
        clearance = min(clearance, operated.clearance)
        X_WC = operated.mount.pose(operated.q)
        assert np.linalg.norm(X_WC[:3, 3] - start) < 0.1
        # Every frame is taken at a pose that was reached.
        if operated.state.frames_wanted > len(taken):
            taken.append(X_WC)
            directions = (X_WC[:3, 2], views[len(taken) - 1][:3, 2])
            assert np.dot(*directions) > np.cos(0.1)
        if operated.state.mode == HOLD:
            break
    assert operated.state.text == "scan done"
    assert operated.context.get_time() < 20
    assert len(taken) == 8
    assert clearance > 0.15
    seen = [seen_voxels(operated, X_WC) for X_WC in taken]
    union = set.union(*seen)
    assert len(union) > 3 * max(map(len, seen))
    # Each view adds something that no other one shows.
    for i, voxels in enumerate(seen):
        others = set.union(*seen[:i], *seen[i + 1 :])
        assert len(voxels - others) > 0.01 * len(voxels)


def seen_voxels(operated: Operated, X_WC: np.ndarray) -> set:
    """Cubes of 5 cm on the scene's surface that a camera sees, up to 3 m."""
    truth = operated.world.truth
    assert truth is not None
    capture = render_capture(truth, [RigidTransform(X_WC)], 80, 60)
    depth = capture.depth[0]
    points = capture.points_W(0)[(depth > 0) & (depth < 3)]
    return set(map(tuple, np.floor(points / 0.05).astype(int)))
