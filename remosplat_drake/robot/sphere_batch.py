"""`SphereBatch`: a robot's spheres in many configurations at once."""

import dataclasses as dc
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres


@dc.dataclass(frozen=True, eq=False)
class SphereBatch:
    """The n spheres of a robot in c configurations, for one distance query.

    The arrays are NumPy's or torch's, also on a GPU. Results have the array
    type of `p_WS`.

    Attributes:
        p_WS: Centres in W, shape (c, n, 3) [m].
        R_WL: Orientations of the spheres' links in W, shape (c, n, 3, 3). Only
            depth views use them.
        radius: Radii, shape (n,) [m].
        ignore_below: Height z in W below which each sphere ignores the scene,
            shape (n,) [m].
    """

    p_WS: Any
    R_WL: Any
    radius: Any
    ignore_below: Any

    def __len__(self) -> int:
        return len(self.p_WS)

    def __iter__(self) -> Iterator[Spheres]:
        """Yields the spheres of each configuration, as NumPy arrays."""
        arrays = (self.p_WS, self.R_WL, self.radius, self.ignore_below)
        p_WS, R_WL, radius, floor = (_on_host(array) for array in arrays)
        for p, R in zip(p_WS, R_WL, strict=True):
            yield Spheres(p, R, radius, floor, np.arange(len(radius)))

    @staticmethod
    def stacked(configurations: Sequence[Spheres]) -> "SphereBatch":
        """Makes a batch of the spheres of one or more configurations.

        Args:
            configurations: The robot's spheres in each configuration. `radius`
                and `ignore_below` are those of the first configuration.

        Example:
            >>> import remosplat_drake as rs
            >>> from remosplat_drake.robot.sphere_batch import SphereBatch
            >>> robot = rs.load_robot("frankie")
            >>> at_home = robot.spheres_at(robot.q_home)
            >>> len(SphereBatch.stacked([at_home, at_home]))
            2
        """
        return SphereBatch(
            np.stack([spheres.p_WS for spheres in configurations]),
            np.stack([spheres.R_WL for spheres in configurations]),
            configurations[0].radius,
            configurations[0].ignore_below,
        )


def _on_host(array: Any) -> np.ndarray:
    if isinstance(array, np.ndarray):
        return array
    return array.detach().cpu().numpy().astype(float)
