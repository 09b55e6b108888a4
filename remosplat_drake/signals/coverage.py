"""`Coverage`: the part of the robot's workspace that cameras have seen."""

import dataclasses as dc

import numpy as np
from numpy.typing import ArrayLike

from remosplat_drake.robot.sphere_model import Spheres

UNSEEN, FREE, SURFACE = 0, 1, 2
"""States of a voxel: no camera has seen it, it is free, or it has a surface."""


@dc.dataclass(frozen=True, eq=False)
class Coverage:
    """An occupancy grid in W of the space that cameras have seen.

    Attributes:
        lower: Lower corner of the grid, shape (3,) [m].
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
        """Returns the states of the voxels that contain points.

        Args:
            p: Points in the grid's frame, shape (n, 3) [m].

        Returns:
            The states, shape (n,), uint8; `UNSEEN` for points outside the grid.
        """
        cell = np.floor((p - self.lower) / self.voxel).astype(int)
        inside = np.all((cell >= 0) & (cell < self.state.shape), axis=1)
        states = self.state[tuple(np.where(inside[:, None], cell, 0).T)]
        return np.where(inside, states, UNSEEN)

    @property
    def upper(self) -> np.ndarray:
        """Upper corner of the grid, shape (3,) [m]."""
        return self.lower + self.voxel * np.array(self.state.shape)


def grid_shape(
    lower: ArrayLike, upper: ArrayLike, voxel: float
) -> tuple[int, int, int]:
    """Returns the number of voxels of a box along each axis.

    Args:
        lower: Lower corner of the box, shape (3,) [m].
        upper: Upper corner of the box, shape (3,) [m].
        voxel: Edge length of a voxel [m].
    """
    size = np.subtract(upper, lower)
    x, y, z = np.maximum(1, np.ceil(size / voxel - 1e-9)).astype(int).tolist()
    return x, y, z


def with_free(coverage: Coverage, spheres: Spheres, margin: float) -> Coverage:
    """Returns a coverage in which voxels that the robot has occupied are free.

    Args:
        coverage: The coverage before this change.
        spheres: The spheres of the robot in one or more configurations without
            contact.
        margin: Space within this distance from the spheres also becomes free
            [m].
    """
    state = coverage.state.copy()
    ball = np.column_stack([spheres.p_WS, spheres.radius + margin])
    # Duplicates are removed, because many spheres are equal: the base does not
    # move while the arm scans.
    for *p_WS, reach in np.unique(ball, axis=0):
        _free_ball(state, coverage, np.array(p_WS), reach)
    return dc.replace(coverage, state=state)


def _free_ball(
    state: np.ndarray, coverage: Coverage, p_WS: np.ndarray, reach: float
) -> None:
    """Marks the unseen voxels that a ball touches as free."""
    shape, voxel = np.array(state.shape), coverage.voxel
    low, high = (
        np.floor((p_WS + side * reach - coverage.lower) / voxel).astype(int)
        for side in (-1, 1)
    )
    low, high = np.clip(low, 0, shape), np.clip(high + 1, 0, shape)
    if (low >= high).any():
        return
    squares = []
    for axis in range(3):
        start = coverage.lower[axis] + voxel * np.arange(low[axis], high[axis])
        gap = np.maximum(start - p_WS[axis], p_WS[axis] - start - voxel)
        squares.append(np.maximum(gap, 0) ** 2)
    x, y, z = np.ix_(*squares)
    block = state[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    block[(x + y + z < reach**2) & (block == UNSEEN)] = FREE
