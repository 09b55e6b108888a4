"""Collects captures from a camera on a robot, without a live map.

This module is for your own programs, with any camera and any robot:

    mount = CameraMount(robot, config.hand_eye(), config.frame)
    with RealSenseCamera() as camera:
        source = RobotFrames(
            image=camera.image, configuration=measured_q, mount=mount
        )
        capture = collect(source, count=12, move=go_to_view)

For the wrist camera of a simulated station, `station_frames` makes the source.
Such a capture is the input of `hand_eye_calibration`.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np
from pydrake.systems.framework import Context, Diagram

from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.rgbd_image import RgbdImage, from_drake
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame, assemble
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports


class FrameSource(Protocol):
    """Protocol of a source of posed images."""

    def frame(self) -> Frame:
        """Takes the latest image, with its pose, and masks the robot."""
        ...


class RobotFrames:
    """A `FrameSource`: the images of a camera that a robot carries."""

    def __init__(
        self,
        *,
        image: Callable[[], RgbdImage],
        configuration: Callable[[float], np.ndarray],
        mount: CameraMount,
    ):
        """Makes a source of frames from a camera and a robot.

        Args:
            image: Function that returns the camera's latest image.
            configuration: Function of a time by the image's clock [s] that
                returns the measured configuration q at this time, shape (n_q,).
                The latest measurement would be too new: at 0.5 m/s, a
                difference of 20 ms shifts walls by 10 mm.
            mount: The camera's mount on the robot.
        """
        self._image = image
        self._configuration = configuration
        self._mount = mount

    def frame(self) -> Frame:
        """Takes the latest image, with its pose X_WC and the robot hidden."""
        image = self._image()
        return self._mount.frame(image, self._configuration(image.time))


def station_frames(
    station: Diagram,
    context: Context,
    robot: RobotModel,
    config: WristCameraConfig,
    margin: float = 0.02,
) -> RobotFrames:
    """Makes a source of frames from a simulated station's wrist camera.

    Args:
        station: A station with a wrist camera and the ports of
            `signals.station_ports`.
        context: The station's context, whose state determines the frames.
        robot: The station's robot.
        config: The camera as the program assumes it. Its hand-eye transform may
            differ from that of the simulated camera.
        margin: Distance by which the robot's spheres are inflated [m].

    Raises:
        RemoSplatError: The robot has no frame with the configured name.
    """
    K = config.intrinsics().intrinsic_matrix()
    color = station.GetOutputPort(ports.WRIST_CAMERA_RGB)
    depth = station.GetOutputPort(ports.WRIST_CAMERA_DEPTH)
    joints = [station.GetOutputPort(ports.arm_position(robot.description))]
    if robot.n_base:
        joints.insert(0, station.GetOutputPort(ports.BASE_POSE))
    return RobotFrames(
        image=lambda: from_drake(
            color.Eval(context), depth.Eval(context), K, context.get_time()
        ),
        # It is evaluated in the same context as the image, so for the same
        # time.
        configuration=lambda _: np.concatenate(
            [port.Eval(context) for port in joints]
        ),
        mount=CameraMount(robot, config.hand_eye(), config.frame, margin),
    )


def collect(
    source: FrameSource,
    count: int,
    move: Callable[[int], None] = lambda i: None,
) -> Capture:
    """Takes several frames, and makes a capture of them.

    Args:
        source: The source of the frames.
        count: Number of frames, 1 or more.
        move: Function that is called with i before frame i is taken. It moves
            the robot, or waits until a person has moved it.
    """
    frames = []
    for i in range(count):
        move(i)
        frames.append(source.frame())
    return assemble(Path("live frames"), frames)
