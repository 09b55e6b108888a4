"""`TaskSurroundings`: a task's objects, contact rules and load at a tick."""

from typing import Protocol

import numpy as np

from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.signals.distance_field import DistanceField


class TaskSurroundings(Protocol):
    """Protocol of a task's objects, contact rules and load."""

    @property
    def payload(self) -> Payload | None:
        """The carried object; None if the robot carries nothing."""
        ...

    def field(self, scene: DistanceField) -> DistanceField:
        """Returns a map to which the objects and the contact rules are added.

        Args:
            scene: The map without the objects.
        """
        ...

    def placed(self, q: np.ndarray) -> tuple[PlacedObject, ...]:
        """Returns the objects whose poses are known.

        Args:
            q: The configuration, shape (n_q,) [rad, m].
        """
        ...
