"""`PointDistanceField`: distance to a cloud of measured surface points.

The points come from the depth images of a capture. Reports use this field if
the true geometry is unknown.
"""

import hashlib

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField


class PointDistanceField(DistanceField):
    """Distances to the nearest point of a point cloud, which has no inside.

    If the centre of a sphere has passed through a surface, its distance is
    positive again. Points are samples of a surface, so distances are never too
    small. In front of a flat surface at the distance d, they are too large by
    at most sqrt(d^2 + s^2) - d. Here s is the largest distance from a point of
    the surface to its nearest sample.

    A sphere ignores points below its `ignore_below`. If the centre coincides
    with a point, the direction is -z.

    Args:
        p_WP: The points in W, shape (n, 3) [m].

    Raises:
        RemoSplatError: The points have another shape or are not finite.
    """

    def __init__(self, p_WP: np.ndarray):
        p_WP = np.array(p_WP, float, order="C")
        if p_WP.ndim != 2 or p_WP.shape[1] != 3:
            raise RemoSplatError(
                f"points have shape {p_WP.shape}; expected (n, 3)"
            )
        if not np.isfinite(p_WP).all():
            raise RemoSplatError("a point of the cloud is not finite")
        p_WP.flags.writeable = False
        self.p_WP = p_WP
        digest = hashlib.sha256(p_WP.tobytes()).hexdigest()[:16]
        self.revision = f"point-distance-{digest}"
        # There is one tree for each value of `ignore_below`; a robot has one or
        # two values.
        self._trees: dict[float, KDTree] = {}

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearance of each sphere to its nearest point.

        Args:
            spheres: The robot spheres, placed in W.
            max_distance: Rows at or beyond this distance are omitted [m].

        Raises:
            ValueError: A centre is not finite, or a radius or `ignore_below` is
                NaN.
        """
        floors = np.asarray(spheres.ignore_below, float)
        bound = spheres.radius + max_distance
        finite = np.isfinite(spheres.p_WS).all()
        if not finite or np.isnan(bound).any() or np.isnan(floors).any():
            raise ValueError(
                "a sphere's centre is not finite, or its radius or"
                " ignore_below is NaN"
            )
        offset = np.full(len(spheres), np.inf)
        p_WC = np.zeros((len(spheres), 3))
        for floor in np.unique(floors):
            tree = self._tree_above(float(floor))
            rows = np.flatnonzero(floors == floor)
            if tree.n == 0 or bound[rows].max() < 0:
                continue
            # The upper bound of the tree's query is exclusive, like
            # `max_distance`.
            offset[rows], point = tree.query(
                spheres.p_WS[rows], distance_upper_bound=bound[rows].max()
            )
            hit = np.flatnonzero(np.isfinite(offset[rows]))
            p_WC[rows[hit]] = tree.data[np.asarray(point)[hit]]
        found = np.flatnonzero(offset - spheres.radius < max_distance)
        offset, p_WC = offset[found], p_WC[found]
        direction_W = p_WC - spheres.p_WS[found]
        direction_W[offset == 0] = [0, 0, -1]
        direction_W /= np.where(offset == 0, 1, offset)[:, None]
        return Clearances(
            sphere=found,
            distance=offset - spheres.radius[found],
            direction_W=direction_W,
            p_WC=p_WC,
            revision=self.revision,
        )

    def _tree_above(self, floor: float) -> KDTree:
        tree = self._trees.get(floor)
        if tree is None:
            tree = KDTree(self.p_WP[self.p_WP[:, 2] >= floor])
            self._trees[floor] = tree
        return tree
