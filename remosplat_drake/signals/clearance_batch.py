"""`ClearanceBatch`: distances to the scene in many robot configurations."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Any

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class ClearanceBatch:
    """Distances of n spheres in c configurations, up to k rows per sphere.

    The arrays are NumPy arrays or torch tensors, like those of the query. A row
    has the same meaning as in `Clearances`. A missing row has an infinite
    distance and the direction zero.

    Attributes:
        distance: Distance from a sphere's surface to the scene, shape (c, n, k)
            [m]; negative if the sphere penetrates it. The gradient of a tensor
            with respect to the spheres' centres is the negative direction.
        direction_W: Unit vectors from the spheres' centres towards the scene,
            in W, shape (c, n, k, 3).
    """

    distance: Any
    direction_W: Any

    def __len__(self) -> int:
        return len(self.distance)

    def minimum(self) -> Any:
        """Returns the smallest distance in each configuration, (c,) [m].

        It is inf for a configuration without rows.
        """
        flat = self.distance.reshape(len(self), -1)
        return flat.min(1) if isinstance(flat, np.ndarray) else flat.amin(1)

    @staticmethod
    def gathered(
        answers: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], n: int
    ) -> "ClearanceBatch":
        """Combines the clearances in c configurations into a batch.

        Args:
            answers: For each of the c configurations, the arrays `sphere`,
                `distance` and `direction_W` of its `Clearances`.
            n: Number of the robot's spheres.
        """
        counts = [np.bincount(row[0], minlength=n) for row in answers]
        most = max((int(count.max(initial=0)) for count in counts), default=0)
        distance = np.full((len(answers), n, max(most, 1)), np.inf)
        direction_W = np.zeros((*distance.shape, 3))
        for c, (sphere, d, n_W) in enumerate(answers):
            order = np.argsort(sphere, kind="stable")
            sphere = sphere[order]
            first = np.cumsum(counts[c]) - counts[c]
            place = np.arange(len(sphere)) - first[sphere]
            distance[c, sphere, place] = d[order]
            direction_W[c, sphere, place] = n_W[order]
        return ClearanceBatch(distance, direction_W)
