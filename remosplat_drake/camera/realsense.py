"""`RealSenseCamera`: an Intel RealSense camera at USB (extra `realsense`).

`remosplat camera-driver` publishes its images over LCM, from which `LcmCamera`
receives them. In your own programs, `live_frames` takes captures with it.
"""

import time

import numpy as np

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.camera.rgbd_image import RgbdImage
from remosplat_drake.capture.undistortion import Distortion

_TIMEOUT = 2000
"""Longest wait for an image [ms]."""


class RealSenseCamera:
    """A RealSense camera, whose depth images are aligned to its colour images.

    It is a context manager, which stops the camera at the end.
    """

    def __init__(
        self,
        width: int = 640,
        height: int = 480,
        fps: int = 30,
        serial: str | None = None,
    ):
        """Starts streaming.

        Args:
            width: Width of both images [pixels].
            height: Height of both images [pixels].
            fps: Images per second [Hz].
            serial: Serial number of the camera; None takes any.

        Raises:
            MissingExtraError: pyrealsense2 is not installed.
            RemoSplatError: The camera is not connected, or does not support
                this size and rate.
        """
        rs = realsense_module()
        _check_connected(rs, serial)
        self._align = rs.align(rs.stream.color)
        self._pipeline = rs.pipeline()
        config = rs.config()
        if serial is not None:
            config.enable_device(serial)
        config.enable_stream(rs.stream.depth, width, height, rs.format.z16, fps)
        config.enable_stream(
            rs.stream.color, width, height, rs.format.rgb8, fps
        )
        try:
            self._pipeline.start(config)
        except RuntimeError as error:
            raise RemoSplatError(
                f"RealSense camera, {width}x{height} at {fps} Hz: {error}"
            ) from error

    def __enter__(self) -> "RealSenseCamera":
        return self

    def __exit__(self, *_: object):
        self.stop()

    def image(self) -> RgbdImage:
        """Waits for the next image.

        The image's time is that of `stamp_of`, by the wall clock [s].

        Raises:
            RemoSplatError: No image arrives within two seconds.
        """
        try:
            frames = self._pipeline.wait_for_frames(_TIMEOUT)
        except RuntimeError as error:
            raise RemoSplatError(f"RealSense camera: {error}") from error
        return from_realsense(self._align.process(frames))

    def stop(self):
        """Stops streaming."""
        self._pipeline.stop()


def from_realsense(frames) -> RgbdImage:
    """Turns an aligned frameset of librealsense into an `RgbdImage`.

    Args:
        frames: A `pyrealsense2.composite_frame` with depth aligned to colour.

    Raises:
        RemoSplatError: Colour or depth is missing, depth is not aligned to
            colour, or the lens has an unsupported distortion model.
    """
    color, depth = frames.get_color_frame(), frames.get_depth_frame()
    if not color or not depth:
        raise RemoSplatError("RealSense camera: colour or depth is missing")
    intrinsics = color.profile.as_video_stream_profile().intrinsics
    steps = np.asarray(depth.get_data())
    rgb = np.array(color.get_data())
    if steps.shape != rgb.shape[:2]:
        raise RemoSplatError(
            "RealSense camera: depth is not aligned to colour: its size is"
            f" {steps.shape[::-1]}, that of colour {rgb.shape[1::-1]}; process"
            " the frames with rs.align"
        )
    return RgbdImage(
        rgb=rgb,
        depth=steps.astype(np.float32) * np.float32(depth.get_units()),
        K=matrix_of(intrinsics),
        time=stamp_of(color, time.time()),
        distortion=distortion_of(intrinsics),
    )


def stamp_of(frame, now: float) -> float:
    """Returns the wall-clock time at which a frame was taken [s].

    By default, librealsense synchronises the camera's clock with the computer's
    clock, and provides the time. If it does not, the result is the present
    time, which is tens of milliseconds late. Images of a moving robot then have
    wrong poses.

    Args:
        frame: A `pyrealsense2.frame`.
        now: The wall clock [s].
    """
    domain = frame.get_frame_timestamp_domain().name
    if domain == "hardware_clock":
        return now
    return 1e-3 * frame.get_timestamp()


def matrix_of(intrinsics) -> np.ndarray:
    """Turns `pyrealsense2.intrinsics` into a matrix K, shape (3, 3) [pixels].

    In librealsense, the centre of the first pixel is (0, 0). In the result it
    is (0.5, 0.5), as in `Capture`.
    """
    return np.array(
        [
            [intrinsics.fx, 0, intrinsics.ppx + 0.5],
            [0, intrinsics.fy, intrinsics.ppy + 0.5],
            [0, 0, 1],
        ]
    )


def distortion_of(intrinsics) -> Distortion | None:
    """Turns `pyrealsense2.intrinsics` into the distortion of a lens.

    The inverse and the modified Brown-Conrady model differ from `Distortion`
    only in second-order tangential terms. For the coefficients of real cameras,
    the difference is less than a hundredth of a pixel.

    Returns:
        The distortion; None for a pinhole camera.

    Raises:
        RemoSplatError: The lens has another distortion model, such as that of a
            fisheye lens.
    """
    if not any(intrinsics.coeffs):
        return None
    if "brown_conrady" not in str(intrinsics.model):
        raise RemoSplatError(
            f"RealSense camera: cannot undistort {intrinsics.model} images"
        )
    k1, k2, p1, p2, k3 = intrinsics.coeffs
    return Distortion(k1=k1, k2=k2, k3=k3, p1=p1, p2=p2)


def _check_connected(rs, serial: str | None):
    """Raises an error at once if no camera is connected."""
    devices = rs.context().query_devices()
    serials = [d.get_info(rs.camera_info.serial_number) for d in devices]
    if not serials:
        raise RemoSplatError("no RealSense camera is connected")
    if serial is not None and serial not in serials:
        raise RemoSplatError(unknown_name("RealSense camera", serial, serials))


def realsense_module():
    """Imports the package `pyrealsense2`.

    Raises:
        MissingExtraError: The package is not installed.
        MissingLibraryError: A system library that the package needs is missing.
    """
    return import_optional("pyrealsense2", "a RealSense camera", "realsense")
