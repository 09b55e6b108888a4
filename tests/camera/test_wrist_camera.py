"""Images of the wrist camera, against distances worked out by hand."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.station.scene_geometry import BOX_COLOUR
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import (
    DynamicStation,
    KinematicStation,
)

CONFIGS = [KinematicStation(), DynamicStation()]


def camera_pose(robot, q0, frame="wrist_camera") -> RigidTransform:
    """X_WC by a plant of our own."""
    plant = MultibodyPlant(time_step=0.0)
    add_robot_model(robot.description, plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = plant.GetPositions(context)
    for name, value in zip(robot.joint_names, q0, strict=True):
        q[plant.GetJointByName(name).position_start()] = value
    plant.SetPositions(context, q)
    return plant.GetFrameByName(frame).CalcPoseInWorld(context)


def box_in_front(X_WC: RigidTransform, distance: float) -> PrimitiveScene:
    """A box that faces the camera squarely, its face at `distance`."""
    X_CP = RigidTransform([0, 0, distance + 0.05])
    return PrimitiveScene(
        boxes=(Box(X_WC @ X_CP, np.array([0.06, 0.06, 0.05])),)
    )


def look(robot, config, q0, scene, camera):
    station = MakeSimulatedStation(
        config=config, robot=robot, scene=scene, q0=q0, wrist_camera=camera
    )
    context = station.CreateDefaultContext()
    return (
        np.array(
            station.GetOutputPort("wrist_camera.depth").Eval(context).data
        ),
        np.array(station.GetOutputPort("wrist_camera.rgb").Eval(context).data),
    )


@pytest.mark.parametrize("config", CONFIGS)
def test_depth_of_a_box_is_its_distance(frankie, config):
    """Depth is along the optical axis [m], so a parallel face is constant."""
    q0 = np.r_[0.3, -0.2, 0.7, frankie.home]
    scene = box_in_front(camera_pose(frankie, q0), 0.25)
    camera = WristCameraConfig(width=40, height=30)
    depth, rgb = look(frankie, config, q0, scene, camera)
    assert depth.dtype == np.float32
    assert depth.shape == (30, 40, 1)
    assert rgb.shape == (30, 40, 4)
    # Half the face, 0.06 m at 0.25 m, is 27 * 0.24 = 6 pixels of 30 rows.
    centre = depth[11:19, 16:24, 0]
    np.testing.assert_allclose(centre, 0.25, atol=1e-4)
    red, green, blue = rgb[15, 20, :3].astype(int)
    assert red > green > blue  # Wood.
    assert BOX_COLOUR[0] > BOX_COLOUR[1] > BOX_COLOUR[2]


def test_the_camera_looks_along_its_z_axis_with_y_down(frankie):
    """A box to the right and above shows up on the right and at the top."""
    q0 = np.r_[0, 0, 0, frankie.home]
    X_CP = RigidTransform([0.06, -0.04, 0.3])
    scene = PrimitiveScene(
        boxes=(
            Box(camera_pose(frankie, q0) @ X_CP, np.array([0.01, 0.01, 0.05])),
        )
    )
    camera = WristCameraConfig(width=40, height=30)
    depth, _ = look(frankie, KinematicStation(), q0, scene, camera)
    rows, columns = np.nonzero(np.abs(depth[..., 0] - 0.25) < 1e-3)
    f = 15 / np.tan(np.deg2rad(29))
    np.testing.assert_allclose(
        columns.mean() + 0.5, 20 + f * 0.06 / 0.25, atol=1
    )
    np.testing.assert_allclose(rows.mean() + 0.5, 15 - f * 0.04 / 0.25, atol=1)


def test_hand_eye_calibration_moves_the_camera(frankie):
    q0 = np.r_[0, 0, 0, frankie.home]
    scene = box_in_front(camera_pose(frankie, q0), 0.25)
    camera = WristCameraConfig(width=8, height=6, translation=[0, 0, 0.1])
    depth, _ = look(frankie, KinematicStation(), q0, scene, camera)
    np.testing.assert_allclose(depth[3, 4, 0], 0.15, atol=1e-4)


def test_out_of_range_is_zero_or_infinite(frankie):
    q0 = np.r_[0, 0, 0, frankie.home]
    scene = box_in_front(camera_pose(frankie, q0), 0.25)
    for limits, value in (((0.3, 5.0), 0.0), ((0.05, 0.2), np.inf)):
        camera = WristCameraConfig(
            width=8, height=6, min_depth=limits[0], max_depth=limits[1]
        )
        depth, _ = look(frankie, KinematicStation(), q0, scene, camera)
        assert depth[3, 4, 0] == value


@pytest.mark.parametrize("config", CONFIGS)
def test_any_frame_can_carry_it(three_link, config):
    """The tip looks along the forearm, 1 m above the floor."""
    q0 = np.array([0.0, np.pi / 2 - 0.3, 0.0])  # The tip looks straight down.
    X_WC = camera_pose(three_link, q0, "tip")
    np.testing.assert_allclose(X_WC.rotation().matrix()[2, 2], -1, atol=1e-9)
    camera = WristCameraConfig(frame="tip", width=8, height=6)
    depth, _ = look(three_link, config, q0, None, camera)
    np.testing.assert_allclose(depth[3, 4, 0], X_WC.translation()[2], atol=1e-3)


def test_the_camera_moves_with_the_base(frankie):
    """A posed scene graph, not one drawn once: the box leaves the view."""
    q0 = np.r_[0, 0, 0, frankie.home]
    X_WC = camera_pose(frankie, q0)
    station = MakeSimulatedStation(
        config=KinematicStation(),
        robot=frankie,
        scene=box_in_front(X_WC, 0.25),
        q0=q0,
        wrist_camera=WristCameraConfig(width=8, height=6),
    )
    context = station.CreateDefaultContext()
    port = station.GetOutputPort("wrist_camera.depth")
    assert abs(port.Eval(context).data[3, 4, 0] - 0.25) < 1e-4
    state = context.get_mutable_continuous_state_vector()
    x = state.CopyToVector()
    x[:2] += [0.5, 0.5]
    state.SetFromVector(x)
    assert port.Eval(context).data[3, 4, 0] > 0.3  # The floor.
