"""`DistanceField` measures distances to the scene, and returns `Clearances`."""

import dataclasses as dc
from abc import ABC, abstractmethod

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.sphere_batch import SphereBatch
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.clearance_batch import ClearanceBatch
from remosplat_drake.signals.compiled_map import IN_PLACE, Maps, Misplacement
from remosplat_drake.signals.thing import THE_MAP, Thing


@dc.dataclass(frozen=True, eq=False)
class Clearances:
    """The m signed distances from robot spheres to the scene, one per row.

    A sphere has no row if there is no surface within the queried distance.
    Otherwise it has one row for its closest point, or several rows, one per
    view or primitive. The arrays are read-only. Copying returns the object
    itself, since Drake's ports deep-copy Python values.

    Attributes:
        sphere: Index of the sphere of each row, shape (m,).
        distance: Distance from the sphere's surface to the scene, shape (m,)
            [m]; negative if the sphere penetrates the scene.
        direction_W: Unit vectors n from the sphere's centre towards the scene,
            in W, shape (m, 3). If the centre moves by eps n, the distance
            changes by -eps. So n is the negative gradient of the distance, also
            inside a solid.
        p_WC: Closest scene point of each row in W, shape (m, 3) [m].
        revision: The `DistanceField.revision` of the field that returned this
            result.

    Example:
        >>> import remosplat_drake as rs
        >>> nothing_near = rs.Clearances.none()
        >>> len(nothing_near), nothing_near.minimum()
        (0, inf)
    """

    sphere: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray
    p_WC: np.ndarray
    revision: str = ""

    def __post_init__(self):
        for name in ("sphere", "distance", "direction_W", "p_WC"):
            getattr(self, name).flags.writeable = False

    def __len__(self) -> int:
        return len(self.distance)

    def __deepcopy__(self, memo) -> "Clearances":
        return self

    @property
    def is_known(self) -> bool:
        """Whether all distances are valid: neither minus infinity nor NaN."""
        return bool(self.distance.min(initial=np.inf) > -np.inf)

    def minimum(self) -> float:
        """Returns the smallest distance [m]; inf if there is no row."""
        return float(self.distance.min(initial=np.inf))

    def per_sphere(self, n: int) -> np.ndarray:
        """Returns the smallest distance of each sphere.

        Args:
            n: Number of the robot's spheres.

        Returns:
            The distances, shape (n,) [m]; inf for a sphere without a row.
        """
        result = np.full(n, np.inf)
        np.minimum.at(result, self.sphere, self.distance)
        return result

    def within(self, distance: float) -> "Clearances":
        """Returns the rows whose distance is less than `distance` [m].

        Rows of unknown distance (NaN) are kept, since they may be near.
        """
        return self.select(~(self.distance >= distance))

    def select(self, keep: np.ndarray) -> "Clearances":
        """Returns some of the rows.

        Args:
            keep: Whether each row is kept, shape (m,), bool.
        """
        if keep.all():
            return self
        return Clearances(
            self.sphere[keep],
            self.distance[keep],
            self.direction_W[keep],
            self.p_WC[keep],
            self.revision,
        )

    @staticmethod
    def none(revision: str = "") -> "Clearances":
        """Makes clearances without rows: nothing is near."""
        empty = np.zeros((0, 3))
        return Clearances(
            np.zeros(0, np.int64), np.zeros(0), empty, empty.copy(), revision
        )

    @staticmethod
    def unknown(n: int) -> "Clearances":
        """Makes clearances of NaN, for spheres at unknown positions.

        Args:
            n: Number of the robot's spheres, each of which gets one row.
        """
        direction_W, p_WC = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
        return Clearances(np.arange(n), np.full(n, np.nan), direction_W, p_WC)


class DistanceField(ABC):
    """An immutable map that answers distance queries for any robot state.

    Fields do not depend on Drake and have no state between queries, so one
    field serves the control tick, verification and rollouts.

    Example:
        >>> import remosplat_drake as rs
        >>> robot = rs.load_robot("frankie")
        >>> scene = rs.read_scene("package://remosplat_drake/models/scenes/table/scene.json")
        >>> field = rs.GroundTruth().make(truth=scene)
        >>> isinstance(field, rs.DistanceField)
        True
        >>> clearances = field.clearances(robot.spheres_at(robot.q_home))
    """

    revision: str
    """Name of the map's content. Fields with equal revisions return equal
    results."""

    is_lipschitz: bool = True
    """Whether moving a sphere by s changes its distance by at most s
    (1-Lipschitz).

    If so, verification can skip spheres that are too far from the scene, and
    its guarantee includes the motion between two queries. Distances from depth
    views, or from a bisection that ends early, are not 1-Lipschitz.
    Verification queries such fields at the end of each tick of a braking ramp,
    and guarantees nothing for the motion in between.
    """

    @property
    def for_look_ahead(self) -> "DistanceField":
        """Returns a field of the same map for rollouts, which may be coarser.

        Safety must not depend on this field; verification queries the field
        itself.
        """
        return self

    @property
    def for_planning(self) -> "DistanceField":
        """Returns a 1-Lipschitz field of the same map for path planning.

        Safety must not depend on this field; verification queries the field
        itself.
        """
        return self

    @property
    def surfaces(self) -> "DistanceField | None":
        """Returns the map without unseen space; None if nothing else is in it.

        The page displays this part of the map, and an operator can click on it.
        """
        return self

    @property
    def compiled(self) -> Packed | None:
        """Returns the map for kernels; None if only Python can query it.

        Planning is several times faster with a compiled map.
        """
        return None

    @property
    def placed(self) -> tuple[Packed, Misplacement] | None:
        """Returns `compiled` and its `Misplacement`, for verification."""
        return None if self.compiled is None else (self.compiled, IN_PLACE)

    @property
    def compiled_rows(self) -> Packed[Maps] | None:
        """Returns the compiled maps from which kernels compute `clearances`.

        Each map gives one row per sphere. The result is None if only Python can
        query the map; rollouts are then several times slower.
        """
        return None

    @abstractmethod
    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearances of all spheres in one call.

        Args:
            spheres: The n robot spheres, placed in W.
            max_distance: Rows at or beyond this distance are omitted [m]. A
                query with a small value takes less time.

        Returns:
            The clearances. A sphere may have no row, one row or several.
        """

    def clearances_batch(
        self, batch: SphereBatch, max_distance: float = np.inf
    ) -> ClearanceBatch:
        """Measures the clearances of a robot in many configurations.

        Fields on a GPU compute thousands of configurations in parallel. Other
        fields process the configurations one by one.

        Args:
            batch: The n robot spheres in c configurations, placed in W.
            max_distance: Rows at or beyond this distance are omitted [m].

        Returns:
            The clearances. All spheres have the same number of rows, which is
            that of the sphere with the most rows.
        """
        answers = [self.clearances(each, max_distance) for each in batch]
        rows = [(a.sphere, a.distance, a.direction_W) for a in answers]
        return ClearanceBatch.gathered(rows, len(batch.radius))

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Returns the kind and name of the object at a point, for display.

        Args:
            p_W: A point in W on a surface, such as the closest point of a
                clearance, shape (3,) [m].
        """
        del p_W  # A map without names returns the same thing for every point.
        return THE_MAP

    def __deepcopy__(self, memo) -> "DistanceField":
        return self
