r"""`UncertainPlacement`: a map whose pose relative to the robot is uncertain.

If the pose of the robot's base is uncertain, the map's pose relative to the
robot is uncertain, too. Let s be the largest position error and t the largest
heading error of the base. Then the map is shifted by at most s, and turned by
at most t about the base's position. A point at the distance r from the base is
displaced by at most s + t r. So a sphere may be nearer to the scene than in the
map by at most

    w = s + t r,

where r is the sphere's horizontal distance from the base. So each sphere has
its own margin, which is larger if the arm is stretched. The margins are valid
along a whole path: the robot's motion relative to its start is known exactly,
and only the start is uncertain.
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
    result is divided by 1 + t, where t is the largest heading error, since w
    changes by at most t per metre. So the field remains 1-Lipschitz and
    conservative.
    """

    def __init__(
        self, field: DistanceField, p_WB: np.ndarray, shift: float, turn: float
    ):
        """Makes a field that subtracts the margins from a map's distances.

        Args:
            field: The map.
            p_WB: x and y of the base in W, shape (2,) [m].
            shift: Upper bound of the position error of the base [m].
            turn: Upper bound of the heading error of the base [rad].
        """
        self._field = field
        self._p_WB = np.array(p_WB)
        self._shift, self._turn = float(shift), float(turn)
        self.revision = field.revision
        self.is_lipschitz = field.is_lipschitz

    @property
    def for_look_ahead(self) -> DistanceField:
        """The map without margins, since safety does not depend on rollouts."""
        return self._field.for_look_ahead

    @property
    def for_planning(self) -> DistanceField:
        """The map without margins, since safety does not depend on planning."""
        return self._field.for_planning

    @property
    def surfaces(self) -> DistanceField | None:
        """The surfaces of the map; None if it has none."""
        return self._field.surfaces

    @property
    def placed(self) -> tuple[Packed, Misplacement] | None:
        """The compiled map, with the bounds of its placement error."""
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
        """Measures clearances, reduced by the margins."""
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
