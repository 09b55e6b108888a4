"""`CompositeDistanceField`: the union of several distance fields."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.oracle.sphere_queries import query_maps
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Maps, together
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import Thing

ROWS = ("all", "closest")
"""The rows that a composite field returns: all rows, or one per sphere."""


class CompositeDistanceField(DistanceField):
    """The union of several distance fields, such as a splat and unseen space.

    Args:
        parts: One or more distance fields in the same frame W.
        rows: "all" returns all rows of all parts, so that the controller has
            rows for the obstacles of each part. "closest" returns one row per
            sphere, which is the closest row of all parts.

    Raises:
        RemoSplatError: There are no parts, or `rows` is not one of `ROWS`.
    """

    def __init__(self, parts: Sequence[DistanceField], rows: str = "all"):
        if not parts:
            raise RemoSplatError(
                "a composite distance field needs at least one part"
            )
        if rows not in ROWS:
            raise RemoSplatError(unknown_name("rows", rows, ROWS))
        self.parts = tuple(parts)
        self.rows = rows
        self.revision = f"{rows}({'+'.join(p.revision for p in self.parts)})"
        self.is_lipschitz = all(part.is_lipschitz for part in self.parts)

    @cached_property
    def for_look_ahead(self) -> "CompositeDistanceField":
        """The union of the parts' fields for rollouts."""
        parts = [part.for_look_ahead for part in self.parts]
        return CompositeDistanceField(parts, self.rows)

    @cached_property
    def for_planning(self) -> "CompositeDistanceField":
        """The union of the parts' fields for planning."""
        parts = [part.for_planning for part in self.parts]
        return CompositeDistanceField(parts, self.rows)

    @cached_property
    def surfaces(self) -> DistanceField | None:
        """The union of the parts' surfaces; None if no part has a surface."""
        parts = [part.surfaces for part in self.parts]
        parts = [part for part in parts if part is not None]
        return CompositeDistanceField(parts, self.rows) if parts else None

    @cached_property
    def compiled(self) -> Packed[Maps] | None:
        """The parts' compiled maps; see `DistanceField.compiled`."""
        parts = [part.compiled for part in self.parts]
        found = [part for part in parts if part is not None]
        return together(found) if len(found) == len(parts) else None

    @cached_property
    def compiled_rows(self) -> Packed[Maps] | None:
        """The parts' compiled rows; see `DistanceField.compiled_rows`."""
        if self.rows == "closest":
            # A compiled query of several maps returns only the nearest result.
            return None if self.compiled is None else together([self.compiled])
        maps = []
        for part in self.parts:
            if part.compiled_rows is None:
                return None
            maps += part.compiled_rows.parts
        return Packed(Maps(tuple(maps)))

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """The clearances of all spheres; see `DistanceField.clearances`.

        If all parts have compiled rows, one kernel queries all of them on one
        thread.
        """
        maps = self.compiled_rows
        if maps is None:
            return self.gathered(spheres, max_distance)
        return query_maps(maps, spheres, max_distance, self.revision)

    def gathered(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Queries the parts one after the other, and sorts their rows.

        This works for parts of any kind; see `DistanceField.clearances`.
        """
        answers = [p.clearances(spheres, max_distance) for p in self.parts]
        sphere = np.concatenate([a.sphere for a in answers])
        distance = np.concatenate([a.distance for a in answers])
        direction_W = np.concatenate([a.direction_W for a in answers])
        p_WC = np.concatenate([a.p_WC for a in answers])
        # The sort is stable, so of rows with equal distances the row of the
        # first part comes first. An unknown distance (NaN) may be the smallest,
        # so it is sorted before all others.
        by_distance = self.rows == "closest"
        nearness = np.where(np.isnan(distance), -np.inf, distance)
        order = (
            np.lexsort((nearness, sphere))
            if by_distance
            else np.argsort(sphere, kind="stable")
        )
        if by_distance:
            _, first = np.unique(sphere[order], return_index=True)
            order = order[first]
        return Clearances(
            sphere[order],
            distance[order],
            direction_W[order],
            p_WC[order],
            self.revision,
        )

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Returns the object at a point, from the part nearest to the point."""
        point = Spheres.at(p_W)
        off = [abs(part.clearances(point).minimum()) for part in self.parts]
        return self.parts[int(np.argmin(off))].thing_at(p_W)
