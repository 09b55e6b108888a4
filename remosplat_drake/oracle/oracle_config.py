"""Configurations of the distance oracles that a scenario may use."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated, Protocol

import numba
from annotated_types import Interval

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.base.ranges import (
    Config,
    OneOf,
    check_ranges,
    joined,
    shown,
)
from remosplat_drake.oracle.backend import BACKENDS, choose_backend
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat


class MissingInputError(RemoSplatError):
    """Raised if an input that an oracle needs is missing."""


@dc.dataclass
class SphereToEllipsoid(Config):
    """The exact distance to the splats as solid ellipsoids or discs.

    Example:
        >>> import remosplat_drake as rs
        >>> splat = rs.read_splat("package://remosplat_drake/models/scenes/table/splat.ply")
        >>> field = rs.SphereToEllipsoid(min_opacity=0.2).make(splat)
    """

    # Semi-axes of a splat, in standard deviations.
    n_sigma: Annotated[float, Interval(gt=0, le=10)] = 1.0
    # Splats below this opacity are ignored. With 0, no floater is ignored.
    min_opacity: Annotated[float, Interval(ge=0, lt=1)] = 0.1
    # Number of bisection steps of the closest point; 0 computes it to double
    # precision. The authors' benchmark used 3 steps.
    bisection_steps: Annotated[int, Interval(ge=0, le=100)] = 0
    # Device that computes distances: `cpu`, `cuda`, or `auto`, which selects
    # cuda if it is available. For one robot, a few CPU cores are as fast as
    # cuda.
    backend: Annotated[str, OneOf(BACKENDS, "backend")] = "cpu"
    # Number of threads of a query on the CPU. With 1, the duration of queries
    # varies least.
    threads: Annotated[int, Interval(ge=1, le=256)] = 1
    # Use of the splats' uncertainty, if the map has it: `subtract` subtracts it
    # from each distance, `ignore` does not use it.
    uncertainty: Annotated[str, OneOf(("subtract", "ignore"))] = "subtract"

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that bisection is used only on the CPU."""
        if self.backend == "cuda" and self.bisection_steps:
            yield "bisection_steps", "must be 0 with `backend: cuda`"

    def make(
        self,
        splat_W: GaussianSplat | None = None,
        truth: PrimitiveScene | None = None,
    ) -> DistanceField:
        """Makes the distance field of a splat.

        Args:
            splat_W: The splat in W.
            truth: Not used.

        Raises:
            MissingInputError: The scene has no splat.
            FieldError: The backend cannot work on this computer.
        """
        del truth  # Unused.
        if splat_W is None:
            raise MissingInputError("SphereToEllipsoid needs scene.splat")
        asked = "cpu" if self.bisection_steps else self.backend
        if choose_backend(asked, "SphereToEllipsoid", "backend") == "cuda":
            from remosplat_drake.oracle.cuda.sphere_to_ellipsoid import (
                CudaSphereToEllipsoidField,
            )

            return CudaSphereToEllipsoidField(
                splat_W,
                n_sigma=self.n_sigma,
                min_opacity=self.min_opacity,
                subtract_uncertainty=self.uncertainty == "subtract",
            )
        return SphereToEllipsoidField(
            splat_W,
            n_sigma=self.n_sigma,
            min_opacity=self.min_opacity,
            bisection_steps=self.bisection_steps or None,
            num_threads=_threads(self),
            subtract_uncertainty=self.uncertainty == "subtract",
        )


@dc.dataclass
class DepthRasterization(Config):
    """Distances in six depth views per sphere, which ignore faint floaters.

    Example:
        >>> import remosplat_drake as rs
        >>> splat = rs.read_splat("package://remosplat_drake/models/scenes/table/splat.ply")
        >>> field = rs.DepthRasterization(resolution=40).make(splat)
        >>> field.is_lipschitz
        False
    """

    # Number of pixels along a side of a view.
    resolution: Annotated[int, Interval(ge=2, le=2048)] = 80
    # Alpha that a pixel must accumulate in order to count as a surface.
    alpha_cutoff: Annotated[float, Interval(gt=0, le=1)] = 0.7
    # Near plane of the views [m].
    near: Annotated[float, Interval(gt=0, le=1)] = 0.0106
    # Far plane of the views, which must exceed `near` [m].
    far: Annotated[float, Interval(gt=0, le=100)] = 0.9
    # Whether only the nearest view of each sphere is computed.
    nearest_only: bool = False
    # Device that renders the views: `cpu`, `cuda`, or `auto`, which selects
    # cuda if it is available.
    backend: Annotated[str, OneOf(BACKENDS, "backend")] = "cpu"
    # Number of threads of a query on the CPU.
    threads: Annotated[int, Interval(ge=1, le=256)] = 1
    # Use of the splats' uncertainty, if the map has it: `subtract` subtracts it
    # from each distance, `ignore` does not use it.
    uncertainty: Annotated[str, OneOf(("subtract", "ignore"))] = "subtract"

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that the near plane is in front of the far plane."""
        if not self.near < self.far:
            yield "far", f"must exceed `near`, got {self.far}"

    def make(
        self,
        splat_W: GaussianSplat | None = None,
        truth: PrimitiveScene | None = None,
    ) -> DistanceField:
        """Makes the distance field of a splat.

        Args:
            splat_W: The splat in W.
            truth: Not used.

        Raises:
            MissingInputError: The scene has no splat.
            FieldError: The backend cannot work on this computer.
        """
        del truth  # Unused.
        if splat_W is None:
            raise MissingInputError("DepthRasterization needs scene.splat")
        # These modules are imported here, since loading their kernels takes
        # time.
        from remosplat_drake.oracle.depth_sensor import DepthSensor

        sensor = DepthSensor(
            resolution=self.resolution,
            alpha_cutoff=self.alpha_cutoff,
            near=self.near,
            far=self.far,
        )
        backend = choose_backend(self.backend, "DepthRasterization", "backend")
        if backend == "cuda":
            from remosplat_drake.oracle.cuda.depth_rasterization import (
                CudaDepthField,
            )

            return CudaDepthField(
                splat_W,
                sensor,
                nearest_only=self.nearest_only,
                subtract_uncertainty=self.uncertainty == "subtract",
            )
        from remosplat_drake.oracle.depth_rasterization import (
            DepthRasterizationField,
        )

        return DepthRasterizationField(
            splat_W,
            sensor,
            nearest_only=self.nearest_only,
            num_threads=_threads(self),
            subtract_uncertainty=self.uncertainty == "subtract",
        )


@dc.dataclass
class GroundTruth(Config):
    """The exact signed distance to the scene's true boxes and cylinders.

    Example:
        >>> import remosplat_drake as rs
        >>> scene = rs.read_scene("package://remosplat_drake/models/scenes/table/scene.json")
        >>> field = rs.GroundTruth().make(truth=scene)
    """

    # Rows of the result: `closest`, one per sphere, or `per_primitive`, one per
    # sphere and primitive.
    rows: Annotated[str, OneOf(("closest", "per_primitive"))] = "closest"

    def make(
        self,
        splat_W: GaussianSplat | None = None,
        truth: PrimitiveScene | None = None,
    ) -> SignedDistanceField:
        """Makes the distance field of the true geometry.

        Args:
            splat_W: Not used.
            truth: The scene's true geometry in W.

        Raises:
            MissingInputError: The scene's true geometry is unknown.
        """
        del splat_W  # Unused.
        if truth is None:
            raise MissingInputError(
                "GroundTruth needs scene.truth or scene.directives"
            )
        return SignedDistanceField(truth, rows=self.rows)


OracleConfig = SphereToEllipsoid | DepthRasterization | GroundTruth
"""Type of the configuration of any oracle of this package."""


class OracleMaker(Protocol):
    """Protocol of an oracle's configuration, for a user's own class."""

    def make(
        self, splat_W: GaussianSplat | None, truth: PrimitiveScene | None
    ) -> DistanceField:
        """Makes the distance field.

        Args:
            splat_W: The scene's splat in W, if it has one.
            truth: The scene's true geometry, if it is known.
        """
        ...


def make_field(
    config: OracleMaker,
    splat_W: GaussianSplat | None,
    truth: PrimitiveScene | None,
    where: str,
) -> DistanceField:
    """Makes the distance field that a configuration describes.

    Args:
        config: The configuration of the oracle.
        splat_W: The scene's splat in W, if it has one.
        truth: The scene's true geometry, if it is known.
        where: The file that contains the configuration; errors name this file.

    Raises:
        FieldError: An input of the oracle is missing, or a value is out of
            range.
    """
    name = type(config).__name__
    if isinstance(config, Config):
        check_ranges(config, where, "oracle")
    try:
        field = config.make(splat_W, truth)
    except MissingInputError as error:
        raise FieldError(where, "oracle", f"!{error}") from error
    except FieldError as error:
        if error.where != name:
            raise
        path = joined("oracle", error.field)
        raise FieldError(where, path, error.problem) from error
    if not isinstance(field, DistanceField):
        problem = f"{name} must make a DistanceField, not {shown(field)}"
        raise FieldError(where, "oracle", problem)
    return field


def _threads(config: SphereToEllipsoid | DepthRasterization) -> int:
    """Returns the number of threads, at most the number of available ones."""
    return min(config.threads, numba.config.NUMBA_NUM_THREADS)  # pyright: ignore
