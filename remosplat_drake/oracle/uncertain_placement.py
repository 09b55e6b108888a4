r"""`UncertainPlacement`: a map with an uncertain pose relative to the robot.

If the base's pose is uncertain, so is the map's pose relative to the robot: the
map is shifted by at most s and turned by at most t about the base's position. A
point at the distance r from there is displaced by at most s + t r. So a sphere
is nearer to the scene by at most

    w = s + t r,

with its lever arm r. So each sphere has its own margin, which is larger for a
stretched arm. The margins are valid along a whole path, since the robot's
motion relative to its start is known exactly; only the start is uncertain.
"""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Misplacement
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import Thing


class UncertainPlacement(DistanceField):
    """A distance field for a robot with an uncertain base pose.

    The margin w of a sphere is subtracted from its distance to the map. The
    result is divided by 1 + t, with the largest heading error t, since w
    changes by t per metre. So the field stays 1-Lipschitz and conservative.
    """

    def __init__(
        self, field: DistanceField, p_WB: np.ndarray, shift: float, turn: float
    ):
        """Enlarges a map's obstacles.

        Args:
            field: The map.
            p_WB: x and y of the base in W, shape (2,) [m].
            shift: Largest position error of the base [m].
            turn: Largest heading error of the base [rad].
        """
        self._field = field
        self._p_WB = np.array(p_WB)
        self._shift, self._turn = float(shift), float(turn)
        self.revision = field.revision
        self.is_lipschitz = field.is_lipschitz

    @property
    def for_look_ahead(self) -> DistanceField:
        """The map without margins: safety does not depend on rollouts."""
        return self._field.for_look_ahead

    @property
    def for_planning(self) -> DistanceField:
        """The map without margins: safety does not depend on planned paths."""
        return self._field.for_planning

    @property
    def surfaces(self) -> DistanceField | None:
        """The surfaces of the map, if it has them."""
        return self._field.surfaces

    @property
    def placed(self) -> tuple[Packed, Misplacement] | None:
        """The map's placement, with this uncertainty."""
        compiled = self._field.compiled
        if compiled is None:
            return None
        x, y = map(float, self._p_WB)
        return compiled, Misplacement(x, y, self._shift, self._turn)

    def margin(self, p_WS: np.ndarray) -> np.ndarray:
        """Returns the margins w of spheres, shape (n,) [m].

        Args:
            p_WS: Centres of spheres in W, shape (n, 3) [m].
        """
        x, y = self._p_WB
        lever = np.hypot(p_WS[:, 0] - x, p_WS[:, 1] - y)
        return self._shift + self._turn * lever

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures clearances minus the uncertainty."""
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
        """Returns the object at a point; see `DistanceField.thing_at`."""
        return self._field.thing_at(p_W)
