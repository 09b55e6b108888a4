"""`DepthRasterizationField`: distances from virtual depth views, on the CPU."""

import copy
import dataclasses as dc
import threading
from collections.abc import Mapping
from functools import cached_property

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.threads import kept_threads
from remosplat_drake.oracle.depth_rows import nearest_rows
from remosplat_drake.oracle.depth_sensor import N_VIEWS, DepthSensor
from remosplat_drake.oracle.kernels.depth_rasterization_kernel import (
    nearest_pixels,
)
from remosplat_drake.oracle.kernels.footprints import (
    footprints_of,
    make_footprints,
    make_rules,
)
from remosplat_drake.oracle.kernels.pixel_runs import Canvas, new_canvas
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

LOOK_AHEAD_RESOLUTION = 24
"""Number of pixels along each side of a depth view in rollouts.

A query of the nearest view at this resolution takes a sixth of the time of a
full query, and its error is some millimetres.
"""


class DepthRasterizationField(DistanceField):
    """Distances measured in six depth views from the centre of every sphere.

    Opacity is taken into account: floaters that are too transparent are ignored
    (paper section IV-C.2). `DepthSensor` contains the exact definition, and the
    result equals that of `depth_rasterization_reference.clearances`. A sphere
    has one row for each view that contains a surface nearer than the queried
    distance, in the order of the views.

    Args:
        splat_W: The scene, expressed in W.
        sensor: The views and the definition of a surface.
        nearest_only: Whether only the nearest view of each sphere is returned.
            This takes less time.
        num_threads: Number of threads that share the spheres of a query. The
            result does not depend on this number.
        subtract_uncertainty: Whether the splats' uncertainty is subtracted from
            distances.
        prepared: The attribute `prepared` of an equal field, so that the
            hierarchy is not built again. Kernels do not check its indices.

    Raises:
        FieldError: `num_threads` is not positive.
    """

    is_lipschitz = False

    def __init__(
        self,
        splat_W: GaussianSplat,
        sensor: DepthSensor | None = None,
        *,
        nearest_only: bool = False,
        num_threads: int = 1,
        subtract_uncertainty: bool = True,
        prepared: Mapping[str, np.ndarray] | None = None,
    ):
        if num_threads < 1:
            raise FieldError(
                "depth rasterization",
                "num_threads",
                f"{num_threads} is not positive",
            )
        self.sensor = sensor or DepthSensor()
        self.nearest_only = nearest_only
        self.num_threads = num_threads
        self.subtract_uncertainty = subtract_uncertainty
        self.revision = (
            f"depth-rasterization-{splat_W.content_hash}-{self.sensor}"
            f"-{nearest_only}-{subtract_uncertainty}"
        )
        if prepared is None:
            footprints = make_footprints(
                splat_W
                if subtract_uncertainty
                else splat_W.with_uncertainty(None),
                self.sensor,
            )
        else:
            nodes = prepared["nodes"]
            nodes.flags.writeable = False
            footprints = footprints_of(nodes, prepared["records"])
        self._footprints = Packed(footprints)
        self._rules = Packed(
            make_rules(
                self.sensor, splat_W.is_surfel, nearest_only=nearest_only
            )
        )
        self._is_surfel = splat_W.is_surfel
        self._splat_W = splat_W

    @property
    def settings(self) -> dict:
        """The constructor's arguments, except the splat, as JSON values."""
        return {
            "sensor": dc.asdict(self.sensor),
            "nearest_only": self.nearest_only,
            "num_threads": self.num_threads,
            "subtract_uncertainty": self.subtract_uncertainty,
        }

    @property
    def prepared(self) -> dict[str, np.ndarray]:
        """Precomputed arrays for the argument `prepared` of an equal field."""
        footprints = self._footprints
        return {"nodes": footprints.nodes, "records": footprints.records}

    @cached_property
    def for_look_ahead(self) -> "DepthRasterizationField":
        """A faster field: only each sphere's nearest view, fewer pixels."""
        resolution = min(self.sensor.resolution, LOOK_AHEAD_RESOLUTION)
        coarse = copy.copy(self)
        coarse.sensor = dc.replace(self.sensor, resolution=resolution)
        coarse.nearest_only = True
        coarse.revision = f"{self.revision}-look-ahead"
        coarse._rules = Packed(
            make_rules(coarse.sensor, self._is_surfel, nearest_only=True)
        )
        return coarse

    @cached_property
    def for_planning(self) -> SphereToEllipsoidField:
        """A Lipschitz continuous field: exact distances to splats as solids."""
        return SphereToEllipsoidField(
            self._splat_W, subtract_uncertainty=self.subtract_uncertainty
        )

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearances of all spheres, one row per view.

        Args:
            spheres: The n robot spheres, placed in W.
            max_distance: Rows at or beyond this distance are omitted [m].

        Returns:
            Up to six rows per sphere, sorted by sphere and then by view.
        """
        if not np.isfinite(spheres.p_WS).all():
            raise ValueError("a sphere's centre is not finite")
        if len(spheres) == 0 or len(self._footprints.records) == 0:
            return Clearances.none(self.revision)
        # The range of a pixel is at most that of the far plane's corners.
        bound = np.minimum(
            self.sensor.far * np.sqrt(3), spheres.radius + max_distance
        )
        R_WD = np.array(self.sensor.R_WD(spheres.R_WL), float, order="C")
        reach, pixel = self._nearest_pixels(spheres, R_WD, bound)
        if self.nearest_only:
            others = np.ones(reach.shape, bool)
            others[np.arange(len(reach)), reach.argmin(axis=1)] = False
            reach[others] = np.inf
        return nearest_rows(spheres, self.sensor, reach, pixel, self.revision)

    def _nearest_pixels(self, spheres, R_WD, bound):
        n = len(spheres)
        threads = min(self.num_threads, n)
        reach = np.full((n, N_VIEWS), np.inf)
        pixel = np.full((n, N_VIEWS), -1)
        p_WS = np.array(spheres.p_WS, float, order="C")
        ignore_below = np.array(spheres.ignore_below, float)

        def share(first: int):
            while first < n:
                canvas = _scratch.canvas(self.sensor.resolution)
                first = nearest_pixels(
                    self._footprints,
                    self._rules,
                    canvas,
                    p_WS,
                    R_WD,
                    ignore_below,
                    bound,
                    first,
                    threads,
                    reach,
                    pixel,
                )
                if first < n:
                    _scratch.enlarge(self.sensor.resolution)

        if threads == 1:
            share(0)
        else:
            # The kernels release the GIL, so Python threads run them in
            # parallel.
            pool = kept_threads("depth-views", threads)
            list(pool.map(share, range(threads)))
        return reach, pixel


class _Scratch(threading.local):
    """Working memory of a thread: one `Canvas` for each resolution."""

    def __init__(self):
        self.canvases: dict[int, Packed[Canvas]] = {}

    def canvas(self, resolution: int) -> Packed[Canvas]:
        """Returns the canvas for views of a resolution."""
        if resolution not in self.canvases:
            room = 4 * resolution**2
            self.canvases[resolution] = new_canvas(resolution, room)
        return self.canvases[resolution]

    def enlarge(self, resolution: int) -> None:
        """Doubles the capacity of the canvas for a resolution."""
        room = len(self.canvases[resolution].runs)
        self.canvases[resolution] = new_canvas(resolution, 2 * room)


_scratch = _Scratch()
