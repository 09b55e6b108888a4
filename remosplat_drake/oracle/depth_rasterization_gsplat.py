"""`GsplatDepthField`: distances from virtual depth views, on a CUDA device.

The results equal those of `DepthRasterizationField`, except where gsplat
deviates from the definition in `DepthSensor`:

- *order*: gsplat sorts the discs of a view by one depth per disc, the same for
  all pixels. So overlapping discs that are not parallel may be composited in
  the wrong order. This causes nearly all of the difference. In trained scenes,
  a quarter to a half of the views with a surface within 0.5 m differ by more
  than a millimetre, and 1 % of them by more than 7 to 14 mm. The distance of
  spheres that touch nothing is over-estimated by at most 6 mm. Above a floor of
  coarse discs, whose order is wrong most often, it is over-estimated by at most
  37 mm.
- *outline*: a disc ends where its alpha falls below 1/255, and not at
  `n_sigma`. For an opaque disc, this is at 3.3 standard deviations.
- *planes*: fragments in front of the near plane or behind the far plane absorb
  light, although they cannot be the result. This happens only if a disc crosses
  the far plane, or if it extends behind the camera, so that the sphere touches
  the disc.
- *clamp*: gsplat limits alpha to 0.999.
- *rounding*: gsplat computes in single precision, which changes the result if
  an alpha is very close to a threshold.

gsplat's 2DGS has three known defects. It uses the depth of a disc's centre for
all pixels. It drops discs whose centres are in front of the near plane. It
bounds discs beside the camera too tightly, which leaves a hole close to the
robot. This module avoids these defects: it intersects each ray with its median
disc, and `gsplat_pairs` and `gsplat_views` place and bound the discs. The
low-pass filter is a setting of the sensor for both backends.

`python -m apps.studies.depth_backends.__main__` counts the differences of each
class for any splat, and measures the duration of both backends.
"""

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.oracle.backend import missing_for_gsplat
from remosplat_drake.oracle.depth_rows import nearest_rows
from remosplat_drake.oracle.depth_sensor import N_VIEWS, DepthSensor
from remosplat_drake.oracle.kernels import gsplat_views as views
from remosplat_drake.oracle.kernels.gsplat_pairs import (
    VIEWS,
    Sensors,
    make_discs,
    visible_pairs,
)
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

if TYPE_CHECKING:
    import torch
    from torch import Tensor

MIN_ALPHA = 1 / 255
"""Alpha below which gsplat drops a fragment."""

TRANSMITTANCE = 0.5
"""Threshold of the transmittance that defines gsplat's median depth."""

_MAX_PAIRS = 1 << 23
"""At most this many pairs of a disc and a view are rendered in one call. A
float represents the index of a pair exactly up to this number."""


class GsplatDepthField(DistanceField):
    """Distances measured in six depth views on a CUDA device (gsplat).

    It computes the same as `DepthRasterizationField`, with unmodified gsplat.
    The docstring of the module lists the differences.

    Args:
        splat_W: The scene, expressed in W; its splats must be 2DGS discs.
        sensor: The views and the definition of a surface.
        nearest_only: Whether only the nearest view of each sphere is returned.
        subtract_uncertainty: Whether the splats' uncertainty is subtracted from
            distances.

    Raises:
        FieldError: The splat has ellipsoids, or a threshold of the sensor
            differs from that of gsplat.
        RemoSplatError: torch, gsplat or a CUDA device is missing.
    """

    is_lipschitz = False

    def __init__(
        self,
        splat_W: GaussianSplat,
        sensor: DepthSensor | None = None,
        *,
        nearest_only: bool = False,
        subtract_uncertainty: bool = True,
    ):
        self.sensor = sensor or DepthSensor()
        self.nearest_only = nearest_only
        self.revision = (
            f"depth-rasterization-gsplat-{splat_W.content_hash}-{self.sensor}"
            f"-{nearest_only}-{subtract_uncertainty}"
        )
        _check(splat_W, self.sensor)
        self._device = _device()
        if not subtract_uncertainty:
            splat_W = splat_W.with_uncertainty(None)
        self._splat_W = splat_W
        self._discs = make_discs(splat_W, MIN_ALPHA, self._device)
        self._rays = views.make_rays(self.sensor, self._device)

    @cached_property
    def for_planning(self) -> SphereToEllipsoidField:
        """A Lipschitz continuous field: exact distances to splats as solids."""
        return SphereToEllipsoidField(self._splat_W)

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
        if len(spheres) == 0:
            return Clearances.none(self.revision)
        reach, pixel = self.nearest_pixels(spheres, max_distance)
        if self.nearest_only:
            others = np.ones(reach.shape, bool)
            others[np.arange(len(reach)), reach.argmin(axis=1)] = False
            reach[others] = np.inf
        return nearest_rows(spheres, self.sensor, reach, pixel, self.revision)

    def nearest_pixels(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> tuple[np.ndarray, np.ndarray]:
        """Finds the nearest pixel of every view.

        At first, discs beyond `max_distance` are omitted. They change the
        result only in views whose nearest surface accumulates too little alpha
        without them. These views are rendered again with all discs.

        Args:
            spheres: The n robot spheres, placed in W.
            max_distance: Pixels at or beyond this distance are ignored [m].

        Returns:
            Two arrays of shape (n, 6), with the views in the order of `R_DV`:
            the range along the pixel's ray [m], and the index of the pixel. The
            range is inf if a view has no surface nearer than `max_distance`.
        """
        bound = spheres.radius + max_distance
        # The range of a pixel is at most that of the far plane's corners.
        everything = np.full(len(spheres), self.sensor.far * math.sqrt(3))
        first = np.minimum(bound, everything)
        answer = self._render(spheres, first, np.ones((len(spheres), N_VIEWS)))
        reach, pixel, open_reach = answer
        best = reach.min(axis=1, keepdims=True) if self.nearest_only else reach
        again = open_reach < np.minimum(best, first[:, None])
        again &= (first < everything)[:, None]
        some = np.flatnonzero(again.any(axis=1))
        if len(some) > 0:
            second = self._render(
                spheres.select(some), everything[some], again[some]
            )
            answer[:, again] = second[:, again[some]]
        reach[reach >= bound[:, None]] = np.inf
        return reach, pixel.astype(np.int64)

    def _render(
        self, spheres: Spheres, reach: np.ndarray, wanted: np.ndarray
    ) -> np.ndarray:
        """Returns range, pixel and open range of all views, shape (3, n, 6)."""
        import torch

        n = len(spheres)
        # One array needs only one transfer from the GPU.
        table = np.empty((n, 14 + N_VIEWS), np.float32)
        table[:, :3] = spheres.p_WS
        R_WD = self.sensor.R_WD(spheres.R_WL)
        table[:, 3:12] = R_WD.swapaxes(1, 2).reshape(n, 9)
        table[:, 12] = spheres.ignore_below
        table[:, 13] = reach
        table[:, 14:] = wanted[:, VIEWS]
        with torch.no_grad():
            answer = self._nearest(torch.from_numpy(table).to(self._device))
            answer = answer.cpu().numpy().astype(float)
        return answer.reshape(3, n, N_VIEWS)[:, :, np.argsort(VIEWS)]

    def _nearest(self, table: "Tensor") -> "Tensor":
        """Returns results of `_render` in the order of `VIEWS`, (3, 6 n)."""
        import torch

        p_WS, R_DW, ignore_below, reach, wanted = table.split(
            [3, 9, 1, 1, N_VIEWS], dim=1
        )
        answer = table.new_full((3, N_VIEWS * len(table)), math.inf)
        answer[1] = 0
        pairs = visible_pairs(
            self._discs,
            Sensors(
                p_WS,
                R_DW.view(-1, 3, 3),
                ignore_below[:, 0],
                reach[:, 0],
                wanted > 0,
            ),
            self.sensor,
        )
        if len(pairs.disc) > _MAX_PAIRS and len(table) > 1:
            halves = table.tensor_split(2)
            return torch.cat([self._nearest(half) for half in halves], dim=1)
        if len(pairs.disc) > 0:
            cameras, nearest = views.render(
                pairs,
                answer.shape[1],
                self._discs,
                self._rays,
                self.sensor,
            )
            for row, values in zip(answer, nearest, strict=True):
                row[cameras] = values.to(row.dtype)
        return answer


def _check(splat_W: GaussianSplat, sensor: DepthSensor) -> None:
    def reject(field: str, problem: str):
        raise FieldError("cuda depth rasterization", field, problem)

    if not splat_W.is_surfel:
        reject("splat", "needs 2DGS discs; use the cpu backend for ellipsoids")
    if sensor.transmittance != TRANSMITTANCE:
        reject("transmittance", f"gsplat supports only {TRANSMITTANCE}")
    if sensor.min_alpha != MIN_ALPHA:
        reject("min_alpha", "gsplat supports only 1/255")


def _device() -> "torch.device":
    """Checks that torch and gsplat work, and returns the CUDA device."""
    problem = missing_for_gsplat()
    if problem:
        raise RemoSplatError(f"cuda depth rasterization {problem}")
    import torch

    return torch.device("cuda")
