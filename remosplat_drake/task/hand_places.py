"""Finds grid points at which a hand is near a surface.

A floor may be large, or seem large because of an outlier. A grid over the whole
floor would then have too many points for a query of all distances. The grid is
therefore divided into boxes. Boxes without a surface nearby are skipped, which
is possible since distances are 1-Lipschitz. All other boxes are searched from
the middle of the grid outwards, only as far as needed.
"""

import dataclasses as dc
import heapq
import math
from collections.abc import Iterator, Sequence

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField

_STEP = 0.1
"""Distance of neighbouring grid points along x and along y [m]."""

_IN_A_BOX, _AT_ONCE = 64, 20_000
"""Boxes with at most this many grid points are not divided further. They are
collected until they contain this many points, which one distance query then
tests."""

_ROUNDING = 1e-9
"""Bound on rounding errors of lengths. It is both a relative error and an
absolute error [m]."""

_Box = tuple[tuple[int, int], ...]
"""A box of grid points: along x, y and z, the first index and the index after
the last."""


@dc.dataclass(frozen=True, eq=False)
class HandPlaces:
    """Finds grid points of a map at which a hand fits, close to a surface.

    At such a point, called a place, the hand's clearance is between `near` and
    `far`.

    Attributes:
        field: Distance field of the scene, 1-Lipschitz.
        hand: The hand's spheres with its end effector at the origin.
        lower: Lower corner of the grid in W, shape (2,) [m].
        upper: Upper corner of the grid in W, shape (2,) [m].
        heights: Heights of the places in W, ascending, shape (h,) [m].
        near: Lower bound on the hand's clearance at a place [m].
        far: Upper bound on the hand's clearance at a place [m].
    """

    field: DistanceField
    hand: Spheres
    lower: np.ndarray
    upper: np.ndarray
    heights: np.ndarray
    near: float
    far: float

    def outwards(
        self,
        p_W: Sequence[float] | np.ndarray = (0, 0, 0),
        radius: float = math.inf,
    ) -> Iterator[np.ndarray]:
        """Yields the places in order of their distance from the middle.

        The distance is horizontal. Places at the same distance are sorted by y,
        then by x, then by z, in ascending order.

        Args:
            p_W: A point in W, shape (3,) [m].
            radius: Places that are farther than this from the point may be
                omitted [m].

        Yields:
            The next places in W, shape (k, 3) [m]; k may be 0.
        """
        boxes = self._searched([self._whole()], p_W, radius)
        found = np.zeros((0, 3))
        while boxes:
            leaves: list[_Box] = []
            while boxes and sum(map(_size, leaves)) < _AT_ONCE:
                _, box = heapq.heappop(boxes)
                if _size(box) <= _IN_A_BOX:
                    leaves.append(box)
                    continue
                for half in self._searched(_halves(box), p_W, radius):
                    heapq.heappush(boxes, half)
            found = np.vstack([found, self._places(leaves)])
            distance = self._from_middle(found)
            farther = boxes[0][0] if boxes else math.inf
            is_next = distance < (1 - _ROUNDING) * farther
            x, y, z = found[is_next].T
            yield found[is_next][np.lexsort((z, x, y, distance[is_next]))]
            found = found[~is_next]

    def _whole(self) -> _Box:
        """The box of all grid points, which may be empty."""
        sides = (self.upper - self.lower).tolist()
        counts = [math.ceil(side / _STEP) for side in sides]
        x, y, z = ((0, max(0, n)) for n in (*counts, len(self.heights)))
        return x, y, z

    def _along(self, axis: int, index: np.ndarray) -> np.ndarray:
        """Coordinates of grid points; along x and y as by `np.arange`."""
        if axis == 2:
            return self.heights[index.astype(int)]
        start = self.lower[axis]
        return start + index * ((start + _STEP) - start)

    def _from_middle(self, p_W: np.ndarray) -> np.ndarray:
        """Horizontal distances from the middle, shape (n,) [m]."""
        middle = 0.5 * (self.lower + self.upper)
        return np.linalg.norm(p_W[:, :2] - middle, axis=1)

    def _searched(
        self,
        boxes: Sequence[_Box],
        p_W: Sequence[float] | np.ndarray,
        radius: float,
    ) -> list[tuple[float, _Box]]:
        """Returns boxes that may contain places, with a distance bound."""
        boxes = [box for box in boxes if _size(box)]
        if not boxes:
            return []
        ends = np.array(boxes, float)
        first, last = (
            np.stack([self._along(i, end[:, i]) for i in range(3)], axis=1)
            for end in (ends[..., 0], ends[..., 1] - 1)
        )
        reach = np.linalg.norm(self.hand.p_WS, axis=1) + self.hand.radius
        bound = np.linalg.norm(0.5 * (last - first), axis=1)
        bound += reach.max() + self.far
        around = Spheres.at(
            0.5 * (first + last),
            (1 + _ROUNDING) * bound + _ROUNDING,
            float(self.hand.ignore_below.min()),
        )
        is_searched = np.zeros(len(boxes), bool)
        is_searched[self.field.clearances(around, 0.0).sphere] = True
        away = np.linalg.norm(np.clip(p_W, first, last) - p_W, axis=1)
        is_searched &= away <= radius
        middle = 0.5 * (self.lower + self.upper)
        nearest = np.clip(middle, first[:, :2], last[:, :2])
        distance = self._from_middle(nearest).tolist()
        return [(distance[i], boxes[i]) for i in np.flatnonzero(is_searched)]

    def _places(self, boxes: Sequence[_Box]) -> np.ndarray:
        """The places in some boxes, shape (k, 3) [m]."""
        grids = [np.zeros((0, 3))]
        for box in boxes:
            axes = [
                self._along(i, start + np.arange(end - start, dtype=float))
                for i, (start, end) in enumerate(box)
            ]
            grids.append(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3))
        p_W, n = np.concatenate(grids), len(self.hand)
        spheres = Spheres(
            (p_W[:, None] + self.hand.p_WS).reshape(-1, 3),
            np.tile(self.hand.R_WL, (len(p_W), 1, 1)),
            np.tile(self.hand.radius, len(p_W)),
            np.tile(self.hand.ignore_below, len(p_W)),
        )
        clearances = self.field.clearances(spheres, self.far)
        room = clearances.per_sphere(len(spheres)).reshape(-1, n).min(axis=1)
        return p_W[(room > self.near) & (room < self.far)]


def _size(box: _Box) -> int:
    """Number of grid points in a box."""
    return math.prod(end - start for start, end in box)


def _halves(box: _Box) -> list[_Box]:
    """Splits a box along its longest side."""
    counts = [end - start for start, end in box]
    axis = counts.index(max(counts))
    start, end = box[axis]
    middle = (start + end) // 2
    return [
        (*box[:axis], half, *box[axis + 1 :])
        for half in ((start, middle), (middle, end))
    ]
