"""`Coverage`: which part of the robot's workspace the cameras have seen."""

import dataclasses as dc

import numpy as np

UNSEEN, FREE, SURFACE = 0, 1, 2
"""What is known of a voxel."""


@dc.dataclass(frozen=True, eq=False)
class Coverage:
    """A grid of voxels over a box of W.

    Attributes:
        lower: Lower corner of the box, shape (3,) [m].
        voxel: Edge of a voxel [m].
        state: `UNSEEN`, `FREE` or `SURFACE`, shape (nx, ny, nz), uint8.
    """

    lower: np.ndarray
    voxel: float
    state: np.ndarray

    def fraction(self, state: int) -> float:
        """The part of the voxels in a state."""
        return float((self.state == state).mean())

    @property
    def upper(self) -> np.ndarray:
        """Upper corner of the grid, shape (3,) [m]."""
        return self.lower + self.voxel * np.array(self.state.shape)
