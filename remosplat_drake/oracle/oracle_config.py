"""The oracles that a scenario may name, and how each is built."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numba
from annotated_types import Interval

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import Config, OneOf, check_ranges
from remosplat_drake.oracle.depth_backend import BACKENDS, choose_backend
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass
class SphereToEllipsoid(Config):
    """The exact distance to the splats as solid ellipsoids or discs."""

    # Semi-axes of a splat, in standard deviations.
    n_sigma: Annotated[float, Interval(gt=0, le=10)] = 1.0
    # Splats below this opacity are ignored; with 0 floaters count, too.
    min_opacity: Annotated[float, Interval(ge=0, lt=1)] = 0.1
    # Number of bisection steps; 0 solves to double precision. The authors'
    # benchmark stopped after 3 steps.
    bisection_steps: Annotated[int, Interval(ge=0, le=100)] = 0
    # Number of threads of a query; 1 is the steadiest.
    threads: Annotated[int, Interval(ge=1, le=256)] = 1


@dc.dataclass
class DepthRasterization(Config):
    """Distances from six depth views a sphere, ignoring faint floaters."""

    # Number of pixels along a side of a view.
    resolution: Annotated[int, Interval(ge=2, le=2048)] = 80
    # Alpha that a pixel must accumulate to count as a surface.
    alpha_cutoff: Annotated[float, Interval(gt=0, le=1)] = 0.7
    # Near plane of the views [m].
    near: Annotated[float, Interval(gt=0, le=1)] = 0.0106
    # Far plane of the views, which must exceed `near` [m].
    far: Annotated[float, Interval(gt=0, le=100)] = 0.9
    # Whether only the nearest view of each sphere is answered.
    nearest_only: bool = False
    # Where views are rendered: `cpu`, `cuda` (gsplat), or `auto`, which is cuda
    # wherever that can work.
    backend: Annotated[str, OneOf(BACKENDS, "backend")] = "cpu"
    # Number of threads of a query on the CPU.
    threads: Annotated[int, Interval(ge=1, le=256)] = 1

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the near plane is nearer than the far plane."""
        if not self.near < self.far:
            yield "far", f"must exceed `near`, got {self.far}"


@dc.dataclass
class GroundTruth(Config):
    """The exact signed distance to the scene's true boxes and cylinders."""

    # Rows of the answer: `closest`, one a sphere, or `per_primitive`, one a
    # sphere and primitive.
    rows: Annotated[str, OneOf(("closest", "per_primitive"))] = "closest"


OracleConfig = SphereToEllipsoid | DepthRasterization | GroundTruth
"""Any of the oracles that a scenario may name."""


def make_field(
    config: OracleConfig,
    splat_W: GaussianSplat | None,
    truth: PrimitiveScene | None,
    where: str,
) -> DistanceField:
    """Builds the distance field that a configuration names.

    Args:
        config: The oracle and its parameters.
        splat_W: The scene's splat in W, if it has one.
        truth: The scene's true geometry, if it is known.
        where: The file that errors name.

    Raises:
        FieldError: The oracle lacks its input, or a value is out of range.
    """
    check_ranges(config, where, "oracle")
    if isinstance(config, GroundTruth):
        if truth is None:
            raise FieldError(where, "oracle", "!GroundTruth needs scene.truth")
        return SignedDistanceField(truth, rows=config.rows)
    if splat_W is None:
        raise FieldError(
            where, "oracle", f"!{type(config).__name__} needs scene.splat"
        )
    if isinstance(config, SphereToEllipsoid):
        return SphereToEllipsoidField(
            splat_W,
            n_sigma=config.n_sigma,
            min_opacity=config.min_opacity,
            bisection_steps=config.bisection_steps or None,
            num_threads=_threads(config),
        )
    return _make_depth_field(config, splat_W, where)


def _threads(config: SphereToEllipsoid | DepthRasterization) -> int:
    """As many threads as are wanted and there are."""
    return min(config.threads, numba.config.NUMBA_NUM_THREADS)  # pyright: ignore


def _make_depth_field(
    config: DepthRasterization, splat_W: GaussianSplat, where: str
) -> DistanceField:
    # Imported here: their kernels cost start-up time that others need not pay.
    from remosplat_drake.oracle.depth_sensor import DepthSensor

    sensor = DepthSensor(
        resolution=config.resolution,
        alpha_cutoff=config.alpha_cutoff,
        near=config.near,
        far=config.far,
    )
    backend = choose_backend(
        config.backend, splat_W.is_surfel, where, "oracle.backend"
    )
    if backend == "cuda":
        from remosplat_drake.oracle.depth_rasterization_gsplat import (
            GsplatDepthField,
        )

        return GsplatDepthField(
            splat_W, sensor, nearest_only=config.nearest_only
        )
    from remosplat_drake.oracle.depth_rasterization import (
        DepthRasterizationField,
    )

    return DepthRasterizationField(
        splat_W,
        sensor,
        nearest_only=config.nearest_only,
        num_threads=_threads(config),
    )
