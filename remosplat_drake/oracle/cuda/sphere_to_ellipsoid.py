"""`CudaSphereToEllipsoidField`: distances to splats as solids, on a GPU."""

import ctypes
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

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
from remosplat_drake.oracle.prepared_solids import splat_records
from remosplat_drake.oracle.sphere_queries import sphere_queries
from remosplat_drake.robot.sphere_batch import SphereBatch
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.clearance_batch import ClearanceBatch
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

if TYPE_CHECKING:
    from torch import Tensor

SOURCE = "nearest_splat.cu"
"""File name of the kernel's CUDA source."""

_THREADS = 128


class CudaSphereToEllipsoidField(DistanceField):
    """`SphereToEllipsoidField`, computed on a CUDA device.

    The computation uses single precision, so distances differ from the CPU's by
    a relative error of about 10^-7. If two splats are equally near, the GPU and
    the CPU may return different splats.

    Args:
        splat_W: The Gaussian splat, expressed in W.
        n_sigma: Length of a splat's semi-axes in standard deviations.
        min_opacity: Splats below this opacity are ignored.
        subtract_uncertainty: Whether the splats' uncertainty is subtracted from
            distances.
        prepared: The attribute `prepared` of an equal field, so that the splats
            are not sorted again. Kernels do not check these arrays.

    Raises:
        RemoSplatError: torch or a CUDA device is missing.
    """

    def __init__(
        self,
        splat_W: GaussianSplat,
        *,
        n_sigma: float = 1.0,
        min_opacity: float = 0.1,
        subtract_uncertainty: bool = True,
        prepared: Mapping[str, np.ndarray] | None = None,
    ):
        self.settings = {
            "n_sigma": n_sigma,
            "min_opacity": min_opacity,
            "subtract_uncertainty": subtract_uncertainty,
        }
        self.revision = (
            f"sphere_to_ellipsoid-cuda:{splat_W.content_hash}"
            f":n_sigma={n_sigma}:min_opacity={min_opacity}"
            f":subtract_uncertainty={subtract_uncertainty}"
        )
        if prepared is None:
            splats = splat_W
            if not subtract_uncertainty:
                splats = splat_W.with_uncertainty(None)
            self._clusters = solid_clusters(splats, min_opacity, n_sigma)
        else:
            self._clusters = Clusters(**prepared)
        self._splat_W = splat_W
        self._is_surfel = ctypes.c_int(splat_W.is_surfel)
        self._scene = DeviceClusters(self._clusters)
        self._program = load_program(SOURCE, self._scene.device.index)

    def __reduce__(self):
        kept = {**self.settings, "prepared": self.prepared}
        return partial(CudaSphereToEllipsoidField, **kept), (self._splat_W,)

    @property
    def prepared(self) -> dict[str, np.ndarray]:
        """Precomputed arrays for the argument `prepared` of an equal field."""
        return dict(vars(self._clusters))

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
        asked = sphere_queries(spheres, max_distance)
        rows = sphere_rows(asked[:, :3], asked[:, 3], asked[:, 4])
        found = self._answer(to_device(rows, self._scene.device))
        answer = found.cpu().numpy().astype(float)
        sphere = np.flatnonzero(answer[:, 0] < 1e30)
        answer = answer[sphere]
        return Clearances(
            sphere=sphere,
            distance=answer[:, 0] - spheres.radius[sphere],
            direction_W=answer[:, 4:7],
            p_WC=spheres.p_WS[sphere] + answer[:, 1:4],
            revision=self.revision,
        )

    def clearances_batch(
        self, batch: SphereBatch, max_distance: float = np.inf
    ) -> ClearanceBatch:
        """Measures clearances of many configurations; see `DistanceField`."""
        reach = on_host(batch.radius) + max_distance
        rows = batch_rows(batch, reach, self._scene.device)
        answer = self._answer(rows).view(*batch.p_WS.shape[:2], 1, 8)
        return batch_answer(batch, answer[..., 0], answer[..., 4:7])

    def _answer(self, rows: "Tensor") -> "Tensor":
        """Returns distances, vectors to closest points, and directions."""
        import torch

        n = len(rows)
        answer = torch.empty((n, 8), dtype=torch.float32, device=rows.device)
        if n == 0:
            return answer
        teams = _THREADS // 32
        self._program.launch(
            "nearest_splats",
            min(-(-n // teams), 1 << 16),
            _THREADS,
            (
                self._scene.argument,
                ctypes.c_void_p(self._scene.order.data_ptr()),
                self._is_surfel,
                ctypes.c_void_p(rows.data_ptr()),
                ctypes.c_int(n),
                ctypes.c_void_p(answer.data_ptr()),
            ),
        )
        return answer


def solid_clusters(
    splat_W: GaussianSplat, min_opacity: float, n_sigma: float
) -> Clusters:
    """Sorts the splats of sufficient opacity into clusters of solids."""
    records, index = splat_records(splat_W, min_opacity, n_sigma)
    axes = records[:, 3:12].reshape(-1, 3, 3) * records[:, 12:15, None]
    half = np.sqrt(np.einsum("nki,nki->ni", axes, axes)) + records[:, 15:]
    return make_clusters(records, half, index)
