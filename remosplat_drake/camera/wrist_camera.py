"""`WristCamera`: protocol of the camera that takes frames for the live map."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from remosplat_drake.capture.frames import Frame
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class WristCamera(Protocol):
    """Protocol of the camera with which the mapping process takes frames.

    `RenderedCamera` and `LcmCamera` implement it. Poses are X_WC with OpenCV
    axes, and the robot's own pixels are hidden in frames.
    """

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """Takes an RGB-D frame now, and computes its pose.

        Args:
            q: The robot's configuration at the time of the request, shape
                (n_q,).
            time: Time of the request, by the diagram's clock [s].

        Returns:
            The frame, whose time is also by the diagram's clock.

        Raises:
            RemoSplatError: The camera provides no frame; the error states the
                reason.
        """
        ...

    def listen(self) -> None:
        """Processes new messages; must be called many times a second."""
        ...

    def place(self, objects: Sequence[PlacedObject]) -> None:
        """Moves objects in the scene of a simulated camera.

        A real camera ignores this.

        Args:
            objects: The objects at their present poses.
        """
        ...

    def show(self, scene: PrimitiveScene) -> None:
        """Changes the scene of a simulated camera.

        Args:
            scene: The solids of the new scene.

        Raises:
            RemoSplatError: The camera is real.
        """
        ...
