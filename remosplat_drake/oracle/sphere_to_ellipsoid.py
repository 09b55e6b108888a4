"""`SphereToEllipsoidField`: exact distance to splats as solid ellipsoids."""

from collections.abc import Mapping
from functools import cached_property
from threading import Lock

import numba
import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.threads import both
from remosplat_drake.oracle.kernels.ellipsoid_distance import CONVERGE
from remosplat_drake.oracle.kernels.nearest_splat import (
    SplatTree,
    query,
    query_parallel,
)
from remosplat_drake.oracle.prepared_solids import prepare_solids
from remosplat_drake.oracle.sphere_queries import query_maps, sphere_queries
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Maps, together
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_ONE_AT_A_TIME = Lock()
"""Lock of parallel loops, since Numba's simplest threading layer aborts if two
of them run at the same time."""


class SphereToEllipsoidField(DistanceField):
    """Exact distance from robot spheres to the splats' n-sigma shapes.

    Section IV-C.1 of the paper describes it. A 3DGS splat is an ellipsoid with
    a signed distance. If a sphere's centre is inside the ellipsoid, the
    distance of the centre is negative, and the direction points away from the
    nearest surface point. A 2DGS splat is a flat, filled disc, which has no
    inside. The distance of a centre from a disc is never negative, and the
    direction flips when the centre crosses the disc. If the centre is on the
    disc, the direction is the disc's normal R_WK[:, 2]. A sphere that
    intersects an ellipsoid or a disc has a negative clearance.

    If splats have an uncertainty, the true surface may be in front of a splat
    by this distance. The clearance of a sphere is then the smallest difference,
    over all splats, of the distance and the uncertainty of a splat. The closest
    point and the direction are those of the n-sigma shape of the splat with
    this difference.

    The result is exact: for any number of threads, it equals that of a search
    over all splats. Of equally near splats, the one with the lowest index is
    returned.
    """

    def __init__(
        self,
        splat_W: GaussianSplat,
        *,
        n_sigma: float = 1.0,
        min_opacity: float = 0.1,
        bisection_steps: int | None = None,
        num_threads: int = 1,
        subtract_uncertainty: bool = True,
        prepared: Mapping[str, np.ndarray] | None = None,
    ):
        """Builds the hierarchy of splats, which takes longer than a tick.

        Args:
            splat_W: The Gaussian splat, expressed in W.
            n_sigma: Length of a splat's semi-axes in standard deviations.
            min_opacity: Splats below this opacity are ignored. With 0, as in
                the paper, floaters block the robot.
            bisection_steps: Number of bisection steps that compute the closest
                point; the authors' benchmark used 3. A distance may then be
                wrong by a large part of the splat's size, but is still a
                distance to a point in the splat's box. The field is then not
                Lipschitz continuous. If the number is None, the closest point
                is computed to double precision.
            num_threads: Number of threads of a query, at most the number of
                cores. With one thread, the duration of queries varies little.
                Two threads are slightly faster in the median, but much slower
                if the cores are busy.
            subtract_uncertainty: Whether the splats' uncertainty is subtracted
                from distances.
            prepared: The attribute `prepared` of an equal field, so that the
                hierarchy is not built again. Kernels do not check its indices.

        Raises:
            ValueError: A parameter is out of range.
        """
        if not (np.isfinite(n_sigma) and n_sigma > 0):
            raise ValueError(f"{n_sigma=} is not positive")
        if bisection_steps is not None and bisection_steps < 0:
            raise ValueError(f"{bisection_steps=} is negative")
        if num_threads < 1:
            raise ValueError(f"{num_threads=} is not positive")
        self.settings = {
            "n_sigma": n_sigma,
            "min_opacity": min_opacity,
            "bisection_steps": bisection_steps,
            "num_threads": num_threads,
            "subtract_uncertainty": subtract_uncertainty,
        }
        if prepared is None:
            kept = splat_W
            if not subtract_uncertainty:
                kept = splat_W.with_uncertainty(None)
            solved = bisection_steps is None
            # Computing the hash of the revision also takes long, so it is done
            # in parallel.
            prepared, _ = both(
                lambda: prepare_solids(kept, n_sigma, min_opacity, solved),
                lambda: splat_W.content_hash,
            )
        for array in prepared.values():
            array.flags.writeable = False
        self._tree = SplatTree(
            prepared["wide"],
            prepared["children"],
            prepared["records"],
            prepared["order"],
            float(n_sigma),
            splat_W.is_surfel,
            CONVERGE if bisection_steps is None else bisection_steps,
        )
        self._packed = Packed(self._tree)
        self.is_lipschitz = bisection_steps is None
        self._num_threads = min(num_threads, numba.config.NUMBA_NUM_THREADS)
        self.revision = (
            f"sphere_to_ellipsoid:{splat_W.content_hash}:n_sigma={n_sigma}"
            f":min_opacity={min_opacity}:bisection_steps={bisection_steps}"
            f":subtract_uncertainty={subtract_uncertainty}"
        )

    @property
    def prepared(self) -> dict[str, np.ndarray]:
        """Precomputed arrays for the argument `prepared` of an equal field."""
        tree = self._tree
        return {
            "wide": tree.wide,
            "children": tree.children,
            "records": tree.records,
            "order": tree.order,
        }

    @property
    def compiled(self) -> Packed[SplatTree]:
        """The splats and their hierarchy; see `DistanceField.compiled`."""
        return self._packed

    @cached_property
    def compiled_rows(self) -> Packed[Maps]:
        """The splats and their hierarchy; see `DistanceField.compiled_rows`."""
        return together([self._packed])

    @property
    def num_splats(self) -> int:
        """Number of splats with sufficient opacity."""
        return len(self._tree.records)

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearance of each sphere to its nearest splat.

        Args:
            spheres: The n robot spheres, placed in W.
            max_distance: Rows at or beyond this distance are omitted [m].

        Returns:
            At most one row per sphere.

        Raises:
            ValueError: A centre is not finite, or a radius or `ignore_below` is
                NaN.
        """
        if self._num_threads == 1:
            maps = self.compiled_rows
            return query_maps(maps, spheres, max_distance, self.revision)
        answer = self._answer(spheres, max_distance)
        found = np.flatnonzero(answer[:, 0] >= 0)
        answer = answer[found]
        return Clearances(
            sphere=found,
            distance=answer[:, 1] - spheres.radius[found],
            direction_W=answer[:, 5:8],
            p_WC=answer[:, 2:5],
            revision=self.revision,
        )

    def nearest_splats(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> tuple[np.ndarray, np.ndarray]:
        """Finds each sphere's nearest splat.

        Args:
            spheres: The n robot spheres, placed in W.
            max_distance: Splats at or beyond this distance are ignored [m].

        Returns:
            The index of the nearest splat, shape (n,), int64, and the clearance
            to it, shape (n,) [m]. They are -1 and inf if no splat is nearer
            than `max_distance`.
        """
        answer = self._answer(spheres, max_distance)
        place = answer[:, 0].astype(np.int64)
        found = place >= 0
        place[found] = self._tree.order[place[found]]
        distance = np.where(found, answer[:, 1] - spheres.radius, np.inf)
        return place, distance

    def _answer(self, spheres: Spheres, max_distance: float) -> np.ndarray:
        asked = sphere_queries(spheres, max_distance)
        answer = np.full((len(spheres), 8), -1.0)
        if self._num_threads == 1:
            query(self._packed, asked, answer)
            return answer
        threads = numba.get_num_threads()
        numba.set_num_threads(self._num_threads)
        try:
            with _ONE_AT_A_TIME:
                query_parallel(self._packed, asked, answer)
        finally:
            numba.set_num_threads(threads)
        return answer
