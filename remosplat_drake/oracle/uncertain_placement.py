r"""`UncertainPlacement`: a map that lies somewhat elsewhere about the robot.

Where the base is uncertain, the map is: seen from the robot, it lies shifted by
at most s and turned by at most t about the base's place. A point at the
distance r from there is displaced by s + t r at most. So a sphere is nearer to
the scene by no more than

    w = s + t r,

with its lever arm r: each sphere gets a margin of its own, and a stretched arm
a larger one. That holds along a whole path: how the robot moves from here on it
knows, only not from where.
"""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Misplacement
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import Thing


class UncertainPlacement(DistanceField):
    """A distance field seen from a robot whose base may be elsewhere.

    Distances are those of the map less w, and divided by 1 + t, since w itself
    changes by t a metre: so the field stays 1-Lipschitz, and promises no more
    than is true.
    """

    def __init__(
        self, field: DistanceField, p_WB: np.ndarray, shift: float, turn: float
    ):
        """Widens a map's obstacles.

        Args:
            field: The map.
            p_WB: x and y of the base in W, shape (2,) [m].
            shift: Greatest distance by which the base may be off [m].
            turn: Greatest angle by which it may be off [rad].
        """
        self._field = field
        self._p_WB = np.array(p_WB)
        self._shift, self._turn = float(shift), float(turn)
        self.revision = field.revision
        self.is_lipschitz = field.is_lipschitz

    @property
    def for_look_ahead(self) -> DistanceField:
        """The map as it is: nothing safe rests on rollouts."""
        return self._field.for_look_ahead

    @property
    def for_planning(self) -> DistanceField:
        """The map as it is: nothing safe rests on paths."""
        return self._field.for_planning

    @property
    def surfaces(self) -> DistanceField | None:
        """The surfaces of the map, where it has them."""
        return self._field.surfaces

    @property
    def placed(self) -> tuple[Packed, Misplacement] | None:
        """The map's own, and how far off it may lie."""
        compiled = self._field.compiled
        if compiled is None:
            return None
        x, y = map(float, self._p_WB)
        return compiled, Misplacement(x, y, self._shift, self._turn)

    def margin(self, p_WS: np.ndarray) -> np.ndarray:
        """Returns how much nearer the scene may be, shape (n,) [m].

        Args:
            p_WS: Centres of spheres in W, shape (n, 3) [m].
        """
        x, y = self._p_WB
        lever = np.hypot(p_WS[:, 0] - x, p_WS[:, 1] - y)
        return self._shift + self._turn * lever

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearances that the uncertainty leaves."""
        if not len(spheres):
            return self._field.clearances(spheres, max_distance)
        margin, scale = self.margin(spheres.p_WS), 1.0 + self._turn
        reach = max_distance * scale + margin.max()
        found = self._field.clearances(spheres, reach)
        return Clearances(
            found.sphere,
            (found.distance - margin[found.sphere]) / scale,
            found.direction_W,
            found.p_WC,
            found.revision,
        ).within(max_distance)

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Says what is at a place; see `DistanceField.thing_at`."""
        return self._field.thing_at(p_W)
