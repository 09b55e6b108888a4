"""`TaskSurroundings`: objects, contacts and load of a task at a tick."""

from typing import Protocol

import numpy as np

from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.signals.distance_field import DistanceField


class TaskSurroundings(Protocol):
    """Objects, contact rules and load of a task, for any map of the scene."""

    @property
    def payload(self) -> Payload | None:
        """The carried object; None for none."""
        ...

    def field(self, scene: DistanceField) -> DistanceField:
        """Returns a map with the objects and the contact rules.

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
