"""`PlacedObject`: the pose of a known object at a moment."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class PlacedObject:
    """The pose of a known object at a moment.

    Attributes:
        name: Name of the object.
        X_WO: Pose of the object, shape (4, 4).
        stands: Whether the object stands on a support. A carried object does
            not.
    """

    name: str
    X_WO: np.ndarray
    stands: bool = True
