"""`Coverage`: which part of the robot's workspace the cameras have seen."""

import dataclasses as dc

import numpy as np

UNSEEN, FREE, SURFACE = 0, 1, 2
"""States of a voxel: no camera saw it; it is free; it holds a surface."""


@dc.dataclass(frozen=True, eq=False)
class Coverage:
    """An occupancy grid in W of what the cameras have seen.

    Attributes:
        lower: Lower corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].
        state: State of each voxel, `UNSEEN`, `FREE` or `SURFACE`, shape (nx,
            ny, nz), uint8.
    """

    lower: np.ndarray
    voxel: float
    state: np.ndarray

    def fraction(self, state: int) -> float:
        """Returns the fraction of the voxels that are in a state."""
        return float((self.state == state).mean())

    def states_at(self, p: np.ndarray) -> np.ndarray:
        """Returns the states of the voxels that points are in.

        Args:
            p: Points in the grid's frame, shape (n, 3) [m].

        Returns:
            Shape (n,), uint8; `UNSEEN` outside of the grid.
        """
        cell = np.floor((p - self.lower) / self.voxel).astype(int)
        inside = np.all((cell >= 0) & (cell < self.state.shape), axis=1)
        states = self.state[tuple(np.where(inside[:, None], cell, 0).T)]
        return np.where(inside, states, UNSEEN)

    @property
    def upper(self) -> np.ndarray:
        """Upper corner of the box, shape (3,) [m]."""
        return self.lower + self.voxel * np.array(self.state.shape)
