"""Live sources of frames: a camera on the robot, simulated or real.

An image says what a camera saw and when. The robot's configuration at that
time says where the camera was, and which pixels show the robot itself.
"""

import dataclasses as dc
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np

from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame, assemble
from remosplat_drake.capture.undistortion import Distortion, undistort


@dc.dataclass(frozen=True, eq=False)
class RgbdImage:
    """Colours and depths of one camera at one time, on one grid.

    Attributes:
        rgb: Colours, shape (h, w, 3), uint8.
        depth: z in C, shape (h, w), float32 [m]; 0 where unknown.
        K: Intrinsic matrix, shape (3, 3) [pixels]; see `Capture`.
        time: When it was taken [s].
        distortion: Of the lens; None for images of a pinhole camera.
    """

    rgb: np.ndarray
    depth: np.ndarray
    K: np.ndarray
    time: float
    distortion: Distortion | None = None

    def __deepcopy__(self, memo) -> "RgbdImage":
        return self


class FrameSource(Protocol):
    """Whatever can tell what it sees now, and from where."""

    def frame(self) -> Frame:
        """The latest posed image, with what is not the scene hidden."""
        ...


class RobotFrames:
    """Frames of a camera that the robot carries."""

    def __init__(
        self,
        *,
        image: Callable[[], RgbdImage],
        configuration: Callable[[float], np.ndarray],
        mount: CameraMount,
    ):
        """Puts the parts together.

        Args:
            image: The camera's latest image.
            configuration: The measured configuration q at a time [s]. An
                image is older than the latest measurement, and an arm at
                0.5 m/s that is 20 ms late puts walls 10 mm off.
            mount: Where the camera sits on the robot.
        """
        self._image = image
        self._configuration = configuration
        self._mount = mount

    def frame(self) -> Frame:
        """The latest image, with its pose, the robot hidden."""
        image = self._image()
        return place(image, self._configuration(image.time), self._mount)


def place(image: RgbdImage, q: np.ndarray, mount: CameraMount) -> Frame:
    """The frame of an image that was taken at configuration q."""
    rgb, depth, outside = image.rgb, image.depth, None
    if image.distortion not in (None, Distortion()):
        rgb, depth, outside = undistort(
            image.distortion, image.K, rgb, depth, None
        )
    hidden = mount.mask(q, image.K, depth)
    return Frame(
        name=f"the frame at {image.time:.3f} s",
        K=image.K,
        X_WC=mount.pose(q),
        rgb=rgb,
        depth=np.where(hidden, np.float32(0), depth),
        hidden=hidden if outside is None else hidden | outside,
        time=image.time,
    )


def collect(
    source: FrameSource,
    count: int,
    move: Callable[[int], None] = lambda i: None,
) -> Capture:
    """A capture of frames from a live source.

    Args:
        source: Of the frames.
        count: How many, at least one.
        move: Called with i before frame i is taken: moves the robot, or
            waits.
    """
    frames = []
    for i in range(count):
        move(i)
        frames.append(source.frame())
    return assemble(Path("live frames"), frames)
