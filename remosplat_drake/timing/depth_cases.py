"""Benchmarks of the depth rasterisation oracle (77 spheres, 80 x 80 pixels).

The scene and the spheres are those of `oracle_cases`.
"""

from functools import partial

from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.timing.measuring import Case
from remosplat_drake.timing.oracle_cases import (
    MAX_DISTANCE,
    robot_spheres,
    table_scene,
)
from remosplat_drake.timing.tick_cases import tick_cases

STOPPING_DISTANCE = 0.021
"""Distance up to which verification's queries search for surfaces [m]."""

SCENARIO = "TableDepth"
"""Shipped scenario whose control ticks use the depth rasterisation oracle."""


def depth_cases() -> list[Case]:
    """Makes benchmarks of queries of 77 spheres, and of control ticks."""
    splat = table_scene(60_000)
    growth = [
        _query(f"{n // 1000}k splats", table_scene(n))
        for n in (10_000, 60_000, 300_000, 1_000_000)
    ]
    return [
        *growth,
        _query("60k splats, 2 threads", splat, num_threads=2),
        _query("60k splats, nearest only", splat, nearest_only=True),
        _query(
            "60k splats, low-pass filter",
            splat,
            sensor=DepthSensor(low_pass_filter=True),
        ),
        _query("60k splats, verification", splat, reach=STOPPING_DISTANCE),
        Case(
            "depth: build, 60k splats", partial(DepthRasterizationField, splat)
        ),
        *tick_cases(SCENARIO, "depth tick"),
    ]


def _query(
    name: str,
    splat: GaussianSplat,
    reach: float = MAX_DISTANCE,
    sensor: DepthSensor | None = None,
    **options,
) -> Case:
    field = DepthRasterizationField(splat, sensor, **options)
    return Case(
        f"depth: query, {name}",
        partial(field.clearances, robot_spheres(), reach),
    )
