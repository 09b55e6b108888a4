"""`Recording`: the files of a capture, whose images are not yet read."""

import dataclasses as dc
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from remosplat_drake.capture.frames import Frame, scale_intrinsics


@dc.dataclass(frozen=True, eq=False)
class DepthImage:
    """A frame's depth image without its colours, as read from a file.

    Attributes:
        name: Name of the frame, which errors contain.
        K: Intrinsic matrix for images of this size, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w), float32 [m]; 0 where it is unknown
            or does not show the scene.
    """

    name: str
    K: np.ndarray
    depth: np.ndarray

    @staticmethod
    def of_color_camera(
        name: str,
        K: np.ndarray,
        color_size: tuple[float, float],
        depth: np.ndarray,
    ) -> "DepthImage":
        """Makes a depth image from the intrinsics of its frame's colour image.

        Args:
            name: Name of the frame.
            K: Intrinsic matrix of the colour image, shape (3, 3) [pixels].
            color_size: Height and width of the colour image [pixels].
            depth: Depth z in C, shape (h, w), float32 [m].
        """
        size = depth.shape[0], depth.shape[1]
        return DepthImage(name, scale_intrinsics(K, color_size, size), depth)


@dc.dataclass(frozen=True, eq=False)
class Recording:
    """Poses of n RGB-D images in files, and functions that read the images.

    Both functions receive ascending indices of frames. In the same order, they
    yield pairs of an index and the data of this frame. They may end early,
    since a video may be shorter than the list of its poses.

    Attributes:
        X_WC: Camera poses (OpenCV axes), shape (n, 4, 4). They are not checked;
            an invalid pose is rejected when its frame is read.
        read_depths: Function that reads the depth images of some frames.
        read_frames: Function that reads some frames in full.
        times: Times at which the images were taken, shape (n,) [s]; None if
            they are unknown.
    """

    X_WC: np.ndarray
    read_depths: Callable[[Sequence[int]], Iterator[tuple[int, DepthImage]]]
    read_frames: Callable[[Sequence[int]], Iterator[tuple[int, Frame]]]
    times: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.X_WC)
