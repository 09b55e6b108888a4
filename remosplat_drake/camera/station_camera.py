"""The wrist camera of a station as a live source of frames."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.framework import Context, Diagram
from pydrake.systems.sensors import CameraInfo, ImageDepth32F, ImageRgba8U

from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.sources import RgbdImage, RobotFrames
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports


def station_frames(
    station: Diagram,
    context: Context,
    robot: RobotModel,
    config: WristCameraConfig,
    margin: float = 0.02,
) -> RobotFrames:
    """Frames of a station's wrist camera, at its measured configuration.

    Args:
        station: Any station with the ports of `station.ports`.
        context: The station's; frames follow its state.
        robot: The station's robot.
        config: With which the camera was made: its hand-eye calibration
            here, which need not be the true one, and its intrinsics.
        margin: By which the robot's spheres are inflated [m].

    Raises:
        RemoSplatError: The robot has no such camera frame.
    """
    K = camera_matrix(config)
    color = station.GetOutputPort(ports.WRIST_CAMERA_RGB)
    depth = station.GetOutputPort(ports.WRIST_CAMERA_DEPTH)
    joints = [station.GetOutputPort(ports.arm_position(robot.description))]
    if robot.n_base:
        joints.insert(0, station.GetOutputPort(ports.BASE_POSE))
    return RobotFrames(
        image=lambda: rgbd_image(
            color.Eval(context), depth.Eval(context), K, context.get_time()
        ),
        # Evaluated together with the image, so it is of the same time.
        configuration=lambda _: np.concatenate(
            [port.Eval(context) for port in joints]
        ),
        mount=CameraMount(robot, hand_eye(config), config.frame, margin),
    )


def rgbd_image(
    color: ImageRgba8U, depth: ImageDepth32F, K: np.ndarray, time: float
) -> RgbdImage:
    """An image from Drake's; depths out of range (0 or inf) are unknown."""
    z = depth.data[..., 0]
    return RgbdImage(
        rgb=color.data[..., :3].copy(),
        depth=np.where(np.isfinite(z), z, np.float32(0)),
        K=K,
        time=time,
    )


def camera_matrix(config: WristCameraConfig) -> np.ndarray:
    """The intrinsic matrix K of a simulated camera [pixels].

    Drake's renderer counts from the image's corner, as `Capture` does.
    """
    fov_y = np.deg2rad(config.fov_y_deg)
    return CameraInfo(config.width, config.height, fov_y).intrinsic_matrix()


def hand_eye(config: WristCameraConfig) -> RigidTransform:
    """The hand-eye transform X_FC of a wrist camera."""
    rpy = RollPitchYaw(np.deg2rad(config.rpy_deg))
    return RigidTransform(rpy, config.translation)
