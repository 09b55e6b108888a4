"""`CudaDepthField`: distances from virtual depth views, on a CUDA device."""

import ctypes
import dataclasses as dc
import math
from collections.abc import Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.oracle.cuda.answers import batch_answer
from remosplat_drake.oracle.cuda.clusters import Clusters, make_clusters
from remosplat_drake.oracle.cuda.device import (
    DeviceClusters,
    batch_rows,
    on_host,
    sphere_rows,
    to_device,
)
from remosplat_drake.oracle.cuda.program import load_program
from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV, DepthSensor
from remosplat_drake.oracle.kernels.footprints import footprint_records
from remosplat_drake.oracle.sphere_queries import sphere_queries
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_batch import SphereBatch
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.clearance_batch import ClearanceBatch
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

if TYPE_CHECKING:
    from torch import Tensor

SOURCE = "depth_views.cu"
"""File name of the kernels' CUDA source."""

LIGHT = 2.0**20
"""Kernels count absorbed light in integers; one unit of absorbed light is this
number of counts. Absorbed light is the negative log2 of the transmittance."""

_BAND, _SMALL_BAND = 6400, 2240
"""Two numbers. A thread block draws at most this many pixels, or one row if a
row has more. The second number applies if there are too few views to occupy all
blocks, and otherwise the first."""

_THREADS = 256
_BLOCKS = 4  # On each multiprocessor.
_ROOM = 4096  # Splats that a block may list at once.
_LISTED_BYTES = 96  # Of each of them, as in the kernel; so is
_KEPT = 12  # how many fragments a thread keeps.
_MOST_OPAQUE = 0.999


class CudaDepthField(DistanceField):
    """`DepthRasterizationField`, computed on a CUDA device.

    The fragments of each ray are composited in their order along the ray, as
    `DepthSensor` defines. The computation uses single precision. So if the
    light absorbed along a ray differs by less than about 10^-6 from a
    threshold, the kernel may choose another fragment as the median.

    Args:
        splat_W: The scene, expressed in W.
        sensor: The views and the definition of a surface.
        nearest_only: Whether only the nearest view of each sphere is returned.
            This takes less time.
        subtract_uncertainty: Whether the splats' uncertainty is subtracted from
            distances.
        prepared: The attribute `prepared` of an equal field, so that the splats
            are not sorted again. Kernels do not check these arrays.

    Raises:
        FieldError: The sensor uses the low-pass filter, or its `alpha_cutoff`
            exceeds 0.999.
        RemoSplatError: torch or a CUDA device is missing.
    """

    is_lipschitz = False

    def __init__(
        self,
        splat_W: GaussianSplat,
        sensor: DepthSensor | None = None,
        *,
        nearest_only: bool = False,
        subtract_uncertainty: bool = True,
        prepared: Mapping[str, np.ndarray] | None = None,
    ):
        self.sensor = sensor or DepthSensor()
        self.nearest_only = nearest_only
        self.subtract_uncertainty = subtract_uncertainty
        self.revision = (
            f"depth-rasterization-cuda-{splat_W.content_hash}-{self.sensor}"
            f"-{nearest_only}-{subtract_uncertainty}"
        )
        check_sensor(self.sensor)
        self._splat_W = splat_W
        if prepared is None:
            splats = splat_W
            if not subtract_uncertainty:
                splats = splat_W.with_uncertainty(None)
            self._clusters = view_clusters(splats, self.sensor)
        else:
            self._clusters = Clusters(**prepared)
        self._rules, self._rules_of_few = (
            RulesArgument.of(
                self.sensor,
                splat_W.is_surfel,
                nearest_only,
                largest_uncertainty(self._clusters),
                band,
            )
            for band in (_BAND, _SMALL_BAND)
        )
        self._scene = DeviceClusters(self._clusters)
        self._blocks = _BLOCKS * self._scene.multiprocessors
        self._R_DV = to_device(view_rotations(), self._scene.device)
        self._program = load_program(SOURCE, self._scene.device.index)

    def __reduce__(self):
        kept = {
            "nearest_only": self.nearest_only,
            "subtract_uncertainty": self.subtract_uncertainty,
            "prepared": self.prepared,
        }
        return partial(CudaDepthField, **kept), (self._splat_W, self.sensor)

    @property
    def settings(self) -> dict:
        """The constructor's arguments, except the splat, as JSON values."""
        return {
            "sensor": dc.asdict(self.sensor),
            "nearest_only": self.nearest_only,
            "subtract_uncertainty": self.subtract_uncertainty,
        }

    @property
    def prepared(self) -> dict[str, np.ndarray]:
        """Precomputed arrays for the argument `prepared` of an equal field."""
        return dict(vars(self._clusters))

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

        Raises:
            ValueError: A centre is not finite, or a radius or `ignore_below` is
                NaN.
        """
        asked = sphere_queries(spheres, max_distance)
        reach = self._bound(asked[:, 3])
        rows = sphere_rows(asked[:, :3], reach, asked[:, 4])
        R_WD = self.sensor.R_WD(spheres.R_WL).astype(np.float32)
        # One transfer of both arrays takes less time than two transfers.
        both = np.concatenate([rows.ravel(), R_WD.ravel()])
        on_device = to_device(both, self._scene.device).split(
            [rows.size, R_WD.size]
        )
        answer = self._answer(
            on_device[0].view(rows.shape), on_device[1].view(len(rows), 9)
        )
        answer = answer.cpu().numpy().astype(float)
        sphere, view = np.nonzero(np.isfinite(answer[..., 0]))
        reach, direction_W = np.split(answer[sphere, view], [1], axis=1)
        return Clearances(
            sphere,
            reach[:, 0] - spheres.radius[sphere],
            direction_W,
            spheres.p_WS[sphere] + reach * direction_W,
            self.revision,
        )

    def clearances_batch(
        self, batch: SphereBatch, max_distance: float = np.inf
    ) -> ClearanceBatch:
        """Measures clearances of many configurations; see `DistanceField`.

        There are six rows per sphere, one per view.
        """
        import torch

        device = self._scene.device
        reach = self._bound(on_host(batch.radius) + max_distance)
        rows = batch_rows(batch, reach, device)
        c, n = batch.p_WS.shape[:2]
        R_WD = torch.eye(3, device=device).expand(c, n, 3, 3)
        if self.sensor.orientation == "link":
            R_WD = torch.as_tensor(batch.R_WL).to(device, torch.float32)
        R_WD = R_WD.reshape(c * n, 9).contiguous()
        answer = self._answer(rows, R_WD).view(c, n, N_VIEWS, 4)
        return batch_answer(batch, answer[..., 0], answer[..., 1:])

    def _bound(self, reach: np.ndarray) -> np.ndarray:
        """Returns ranges, limited to the range of the far plane's corners."""
        return np.minimum(reach, self.sensor.far * math.sqrt(3))

    def _answer(self, rows: "Tensor", R_WD: "Tensor") -> "Tensor":
        """Returns ranges and directions of the nearest pixels, (n, 6, 4)."""
        import torch

        n, device = len(rows), rows.device
        answer = torch.empty((n, N_VIEWS, 4), device=device)
        if n == 0:
            return answer
        n_views = N_VIEWS * n
        few = n_views * self._rules.bands < 8 * self._blocks
        rules = self._rules_of_few if few else self._rules
        blocks = min(n_views * rules.bands, self._blocks)
        # The buffer contains the keys of the views (64 bits), the keys of the
        # spheres (32 bits), and the work counter.
        keys = torch.full(
            (n_views + n // 2 + 1,), -1, dtype=torch.int64, device=device
        )
        lists = torch.empty(
            blocks * rules.list_bytes, dtype=torch.uint8, device=device
        )
        spheres, rotations, views, nearest, closest, work, listed, found = map(
            ctypes.c_void_p,
            (
                rows.data_ptr(),
                R_WD.data_ptr(),
                self._R_DV.data_ptr(),
                keys.data_ptr(),
                keys.data_ptr() + 8 * n_views,
                keys.data_ptr() + 8 * n_views + 4 * n,
                lists.data_ptr(),
                answer.data_ptr(),
            ),
        )
        asked = (rotations, views, ctypes.c_int(n), nearest)
        self._program.launch(
            "depth_views",
            blocks,
            _THREADS,
            (
                self._scene.argument,
                rules,
                spheres,
                *asked,
                closest,
                work,
                listed,
            ),
            rules.scratch_bytes,
        )
        self._program.launch(
            "depth_rows",
            min(math.ceil(n_views / _THREADS), 1024),
            _THREADS,
            (rules, *asked, found),
        )
        return answer


class RulesArgument(ctypes.Structure):
    """Settings of a `DepthSensor` as an argument of depth_views.cu."""

    _fields_ = (
        ("resolution", ctypes.c_int),
        ("band_rows", ctypes.c_int),
        ("bands", ctypes.c_int),
        ("is_surfel", ctypes.c_int),
        ("nearest_only", ctypes.c_int),
        ("median_light", ctypes.c_uint32),
        ("opaque_light", ctypes.c_uint32),
        ("most_light", ctypes.c_uint32),
        ("near", ctypes.c_float),
        ("far", ctypes.c_float),
        ("uncertainty", ctypes.c_float),
        ("room", ctypes.c_uint32),
    )

    @staticmethod
    def of(
        sensor: DepthSensor,
        is_surfel: bool,
        nearest_only: bool,
        uncertainty: float,
        band: int = _BAND,
        room: int = _ROOM,
    ) -> "RulesArgument":
        """Makes the argument from the settings of a sensor.

        Args:
            sensor: The views.
            is_surfel: Whether the splats are discs.
            nearest_only: Whether only a sphere's nearest view is computed.
            uncertainty: The largest uncertainty of the splats [m].
            band: A thread block draws at most this many pixels, or one row if a
                row has more.
            room: Capacity of a thread block's list of splats.
        """
        r = sensor.resolution
        band_rows = math.ceil(r / math.ceil(r * r / band))
        median = round(-math.log2(sensor.transmittance) * LIGHT)
        opaque = round(-math.log2(1 - sensor.alpha_cutoff) * LIGHT)
        return RulesArgument(
            resolution=r,
            band_rows=band_rows,
            bands=math.ceil(r / band_rows),
            is_surfel=is_surfel,
            nearest_only=nearest_only,
            median_light=median,
            opaque_light=opaque,
            # The light of larger alphas is clamped to this limit, which does
            # not change the result.
            most_light=max(median, opaque),
            near=sensor.near,
            far=sensor.far,
            uncertainty=uncertainty,
            room=room,
        )

    @property
    def scratch_bytes(self) -> int:
        """Shared memory of a block, for pixels and fragments [bytes]."""
        return 12 * self._words + 8 * _KEPT * _THREADS

    @property
    def list_bytes(self) -> int:
        """Memory for a block's list of splats and its pixels' keys [bytes]."""
        return _LISTED_BYTES * self.room + 128 * self._words

    @property
    def _words(self) -> int:
        """Number of 32-bit words that contain one bit per pixel of a band."""
        return math.ceil(self.band_rows * self.resolution / 32)


def check_sensor(sensor: DepthSensor) -> None:
    """Checks that the kernel supports the settings of a sensor.

    Raises:
        FieldError: The kernel does not support a setting; the error names it.
    """
    if sensor.low_pass_filter:
        raise FieldError(
            "depth sensor",
            "low_pass_filter",
            "is not available in the cuda backend; use the cpu backend",
        )
    if sensor.alpha_cutoff > _MOST_OPAQUE:
        raise FieldError(
            "depth sensor",
            "alpha_cutoff",
            f"the cuda backend takes at most {_MOST_OPAQUE}, got"
            f" {sensor.alpha_cutoff}; use the cpu backend",
        )


def view_clusters(splat_W: GaussianSplat, sensor: DepthSensor) -> Clusters:
    """Sorts the splats that a sensor can see into `Clusters`."""
    seen, half = footprint_records(splat_W, sensor)
    index = seen[:, 15].astype(np.int64)
    records = np.zeros_like(seen)
    records[:, :3] = seen[:, :3]
    records[:, 3] = seen[:, 14]
    records[:, 4:13] = seen[:, 3:12]
    records[:, 13:15] = seen[:, 12:14]
    if splat_W.uncertainty is not None:
        records[:, 15] = splat_W.uncertainty[index]
    return make_clusters(records, half + records[:, 15:], index)


def largest_uncertainty(clusters: Clusters) -> float:
    """Returns the largest uncertainty of splats that a sensor can see [m]."""
    return float(clusters.records[:, 15].max(initial=0.0))


def view_rotations() -> np.ndarray:
    """Returns the views' orientations in the kernel's layout, shape (6, 9)."""
    return R_DV.reshape(N_VIEWS, 9).astype(np.float32)
