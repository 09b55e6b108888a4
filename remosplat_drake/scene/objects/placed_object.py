"""`PlacedObject`: the pose of a known object at a moment."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class PlacedObject:
    """The pose of a known object at a moment.

    Attributes:
        name: Its name.
        X_WO: Its pose, shape (4, 4).
        stands: Whether it stands on a support; a carried object does not.
    """

    name: str
    X_WO: np.ndarray
    stands: bool = True
