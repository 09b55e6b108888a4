"""A distance oracle of your own, here a wall that is not in the splat.

An oracle is a `Config` with a method `make` that returns a `DistanceField`. A
field is immutable, and computes the distances of all spheres in one call. In a
scenario, you select it by `oracle: !my_module:Wall {x: 1.2}`.
"""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval

import remosplat_drake as rs


class HalfSpace(rs.DistanceField):
    """A distance field: everything beyond a plane x = constant is solid."""

    def __init__(self, x: float):
        """Stores the plane's position x [m]."""
        self._x = x
        self.revision = f"half-space-{x}"

    def clearances(self, spheres, max_distance=np.inf) -> rs.Clearances:
        """Returns one row for each sphere within `max_distance`."""
        distance = self._x - spheres.p_WS[:, 0] - spheres.radius
        near = np.flatnonzero(distance < max_distance)
        p_WC = spheres.p_WS[near].copy()
        p_WC[:, 0] = self._x
        towards = np.tile([1.0, 0.0, 0.0], (len(near), 1))
        return rs.Clearances(near, distance[near], towards, p_WC, self.revision)


@dc.dataclass
class Wall(rs.Config):
    """Settings of a vertical wall in front of the robot."""

    # Position of the wall along x [m].
    x: Annotated[float, Interval(ge=-100, le=100)] = 1.2

    def make(self, splat_W=None, truth=None) -> rs.DistanceField:
        """Returns the wall; the scene's splat and truth are unused."""
        return HalfSpace(self.x)


def main() -> None:
    """Prints the robot's least distance to walls at decreasing distances."""
    for x in (1.5, 1.1, 0.9):
        scenario = rs.load_scenario("TableReach")
        scenario.oracle, scenario.time_limit = Wall(x), 6.0
        result = rs.run(rs.build(scenario))
        nearest = result.metrics.clearance_min
        print(f"wall at {x} m: {result.outcome}, nearest {nearest:.4f} m")


if __name__ == "__main__":
    main()
