"""The oracles that a scenario may name, and how each is built."""

import dataclasses as dc

from remosplat_drake.errors import FieldError
from remosplat_drake.oracle.depth_backend import choose_backend
from remosplat_drake.oracle.distance_field import DistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass
class SphereToEllipsoid:
    """The exact distance to the splats as solid shapes."""

    # Semi-axes of a splat in standard deviations.
    n_sigma: float = 1.0
    # Splats below this opacity do not count; 0 counts floaters too.
    min_opacity: float = 0.1
    # 0 solves exactly; the authors' benchmark stopped after 3 steps.
    bisection_steps: int = 0
    # Threads of a query; 1 is the steadiest.
    threads: int = 1


@dc.dataclass
class DepthRasterization:
    """Six depth views from every sphere: opacity counts, floaters do not."""

    # Pixels along a side of a view.
    resolution: int = 80
    # Opacity that a pixel must gather to count as a surface.
    alpha_cutoff: float = 0.7
    # Near and far plane of the views [m].
    near: float = 0.0106
    far: float = 0.9
    # Only the nearest view of each sphere.
    nearest_only: bool = False
    # `cpu`, `cuda` (gsplat), or `auto`: cuda wherever it can work.
    backend: str = "cpu"
    # Threads of a query on the CPU.
    threads: int = 1


@dc.dataclass
class GroundTruth:
    """The exact signed distance to the scene's true geometry."""

    # `closest` a sphere, or `per_primitive`.
    rows: str = "closest"


OracleConfig = SphereToEllipsoid | DepthRasterization | GroundTruth


def make_field(
    config: OracleConfig,
    splat_W: GaussianSplat | None,
    truth: PrimitiveScene | None,
    where: str,
) -> DistanceField:
    """Builds the field that a configuration names.

    Args:
        config: Which oracle, and its parameters.
        splat_W: The scene's splat in W, if it has one.
        truth: The scene's true geometry, if it is known.
        where: The file to blame.

    Raises:
        FieldError: The oracle lacks its input, or a value is out of range.
    """
    if isinstance(config, GroundTruth):
        if truth is None:
            raise FieldError(where, "oracle", "!GroundTruth needs scene.truth")
        if config.rows not in ("closest", "per_primitive"):
            raise FieldError(
                where,
                "oracle.rows",
                f"unknown {config.rows!r}; valid: closest, per_primitive",
            )
        return SignedDistanceField(truth, rows=config.rows)
    if splat_W is None:
        raise FieldError(
            where, "oracle", f"!{type(config).__name__} needs scene.splat"
        )
    _check_ranges(config, where)
    if isinstance(config, SphereToEllipsoid):
        return SphereToEllipsoidField(
            splat_W,
            n_sigma=config.n_sigma,
            min_opacity=config.min_opacity,
            bisection_steps=config.bisection_steps or None,
            num_threads=config.threads,
        )
    return _make_depth_field(config, splat_W, where)


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
        num_threads=config.threads,
    )


def _check_ranges(
    config: SphereToEllipsoid | DepthRasterization, where: str
) -> None:
    def require(ok: bool, field: str, problem: str):
        if not ok:
            value = getattr(config, field)
            raise FieldError(
                where, f"oracle.{field}", f"{problem}, got {value}"
            )

    require(config.threads >= 1, "threads", "must be at least 1")
    if isinstance(config, SphereToEllipsoid):
        require(config.n_sigma > 0, "n_sigma", "must be positive")
        require(
            0 <= config.min_opacity < 1, "min_opacity", "must lie in [0, 1)"
        )
        require(
            config.bisection_steps >= 0,
            "bisection_steps",
            "must not be negative",
        )
    else:
        require(config.resolution >= 2, "resolution", "must be at least 2")
        require(
            0 < config.alpha_cutoff <= 1,
            "alpha_cutoff",
            "must lie in (0, 1]",
        )
        require(config.near > 0, "near", "must be positive")
        require(config.near < config.far, "far", "must exceed `near`")
