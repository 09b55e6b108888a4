"""`Room`: the distances that a robot keeps while its axes are identified."""

import dataclasses as dc

import numpy as np

from remosplat_drake.app.identification.reading import Reading
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.controller.verification.verify import Surroundings
from remosplat_drake.signals.distance_field import DistanceField


class NoRoomError(RemoSplatError):
    """Raised if an axis cannot move without coming too near to an obstacle."""


@dc.dataclass(frozen=True, eq=False)
class Room:
    """The scene, and the distances that a robot keeps from it and from itself.

    Attributes:
        field: The map.
        own: Distances that the robot's parts keep from each other.
        clearance: Distance that all spheres keep from the scene [m].
        dt: Control period [s].
    """

    field: DistanceField
    own: SelfClearance
    clearance: float
    dt: float

    def about(self, reading: Reading) -> "Room":
        """Returns a copy whose map allows for the base pose's uncertainty.

        Args:
            reading: The states of the base's drivers.
        """
        return dc.replace(self, field=reading.seen(self.field))

    def problem(self, q: np.ndarray) -> str:
        """Describes two parts, or a part and the scene, that are too near.

        It returns an empty text if all distances are large enough.

        Args:
            q: The configuration in the map, shape (n_q,) [m, rad].
        """
        if not np.isfinite(q).all():
            return "the robot's pose in the map is unknown"
        spheres = self.own.robot.spheres_at(q)
        least = self.clearance
        nearest = self.field.clearances(spheres, least).minimum()
        if not nearest >= least:
            return (
                f"the scene is {1e3 * nearest:.0f} mm away, nearer than the "
                f"required {1e3 * least:.0f} mm"
            )
        apart = self.own.distances(q, self.own.stopping)
        if not (apart >= self.own.stopping).all():
            links = " and ".join(self.own.pairs.links(int(apart.argmin())))
            return f"{links} are too near to each other"
        return ""

    def surroundings(self, q: np.ndarray) -> Surroundings:
        """Returns the data with which verification checks paths.

        Args:
            q: Configuration at which the paths start, for which `problem`
                returns "", shape (n_q,) [m, rad].
        """
        robot, reach = self.own.robot, 2.0 * self.clearance
        state = robot.state(q)
        found = self.field.clearances(state.spheres, reach)
        return Surroundings(
            robot,
            self.field,
            state,
            np.minimum(found.per_sphere(len(robot.spheres)), reach),
            self.clearance,
            self.dt,
            self.own,
        )
