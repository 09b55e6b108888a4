"""Frames of the simulated robot's own camera, as it moves its arm."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from remosplat_drake.camera.live_frames import collect, station_frames
from remosplat_drake.camera.rgbd_image import from_drake
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.checks.inspection import inspect_capture
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import KinematicStation

CAMERA = WristCameraConfig(
    width=160,
    height=120,
    translation=[0.02, -0.03, 0.01],
    rpy_deg=[-30.0, 5.0, 10.0],
)


def collect_frames(robot, scene, believed: WristCameraConfig, n: int = 6):
    """Frames around the scene, with the camera believed to be elsewhere."""
    start = np.r_[0.2, 0.0, 0.0, robot.home]
    station = MakeSimulatedStation(
        config=KinematicStation(),
        robot=robot,
        scene=scene,
        q0=start,
        wrist_camera=CAMERA,
    )
    context = station.CreateDefaultContext()

    arm = np.random.default_rng(0).normal(0, 0.15, (n, 7))

    def move(i: int):
        q = start + np.r_[0.02 * i, 0.05 * i, -0.05 * i, arm[i]]
        state = context.get_mutable_continuous_state_vector()
        x = state.CopyToVector()
        x[: len(q)] = q
        state.SetFromVector(x)

    source = station_frames(station, context, robot, believed)
    return collect(source, n, move)


def scene_distances(scene, capture) -> np.ndarray:
    """Distances of all the capture's points from the true scene [m]."""
    points = [capture.points_W(i).reshape(-1, 3) for i in range(len(capture))]
    points = np.concatenate(points)
    points = points[np.isfinite(points[:, 0])]
    return SignedDistanceField(scene).clearances(Spheres.at(points)).distance


@pytest.fixture(scope="module")
def capture(frankie, scene):
    return collect_frames(frankie, scene, CAMERA)


def test_all_points_lie_on_the_scene(scene, capture):
    """And so none lies on the robot, which the camera sees as well."""
    distance = scene_distances(scene, capture)
    assert len(distance) > 0.5 * capture.depth.size
    # Drake draws a cylinder of 5 cm as a prism that is 0.1 mm flatter.
    assert np.abs(distance).max() < 1e-3


def test_the_capture_passes_its_inspection(capture):
    inspection = inspect_capture(capture)
    assert inspection.findings == ()
    assert inspection.hidden > 0
    assert inspection.overlap.agreement > 0.99


def test_a_wrong_hand_eye_transform_shows(frankie, scene, capture):
    wrong = dc.replace(CAMERA, rpy_deg=[-30.0, 5.0, 25.0])
    bad = collect_frames(frankie, scene, wrong)
    assert np.abs(scene_distances(scene, bad)).max() > 0.01
    good = inspect_capture(capture).overlap
    assert inspect_capture(bad).overlap.median > 10 * good.median


def test_depths_out_of_range_are_unknown():
    color, depth = ImageRgba8U(2, 2), ImageDepth32F(2, 2)
    color.mutable_data[:] = np.arange(16).reshape(2, 2, 4)
    depth.mutable_data[..., 0] = [[0, 1.5], [np.inf, np.nan]]
    image = from_drake(color, depth, np.eye(3), 0.5)
    np.testing.assert_array_equal(image.depth, [[0, 1.5], [0, 0]])
    np.testing.assert_array_equal(image.rgb[1, 0], [8, 9, 10])
    # Drake's buffers change with the next image; ours stay.
    color.mutable_data[:] = 0
    assert image.rgb[1, 0, 0] == 8
