"""`WristCamera`: what the mapping process takes its pictures with."""

from typing import Protocol

import numpy as np

from remosplat_drake.capture.frames import Frame
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class WristCamera(Protocol):
    """A camera that the robot carries, simulated or real."""

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """What it sees now, with its pose, the robot hidden.

        Args:
            q: The robot's configuration when the frame was asked for, shape
                (n_q,).
            time: When that was, by the diagram's clock [s].

        Returns:
            A frame whose time is of the diagram's clock too.

        Raises:
            RemoSplatError: It sees nothing; says why.
        """
        ...

    def listen(self) -> None:
        """Takes in what has arrived; called many times a second."""
        ...

    def show(self, scene: PrimitiveScene) -> None:
        """Changes what there is to see.

        Raises:
            RemoSplatError: The camera is a real one.
        """
        ...
