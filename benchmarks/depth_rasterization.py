"""Speed of the depth rasterisation oracle: 77 spheres, six views of 80 x 80.

Scene and spheres are those of the sphere-to-ellipsoid oracle's benchmark.
"""

from collections.abc import Callable

from remosplat_drake.benchmark.oracle_cases import (
    MAX_DISTANCE,
    robot_spheres,
    table_scene,
)
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def cases() -> list[tuple[str, Callable[[], object]]]:
    """What to time: names and calls."""
    spheres = robot_spheres()
    splat = table_scene(60_000)
    unfiltered, filtered = DepthSensor(), DepthSensor(low_pass_filter=True)

    def query(scene: GaussianSplat, sensor: DepthSensor, **options):
        field = DepthRasterizationField(scene, sensor, **options)
        return lambda: field.clearances(spheres, MAX_DISTANCE)

    return [
        ("depth views: 10k splats", query(table_scene(10_000), unfiltered)),
        ("depth views: 60k splats", query(splat, unfiltered)),
        ("depth views: 1000k splats", query(table_scene(10**6), unfiltered)),
        (
            "depth views: 60k splats, 2 threads",
            query(splat, unfiltered, num_threads=2),
        ),
        (
            "depth views: 60k splats, nearest only",
            query(splat, unfiltered, nearest_only=True),
        ),
        (
            "depth views: 60k splats, low-pass filter",
            query(splat, filtered),
        ),
        (
            "depth views: build, 60k splats",
            lambda: DepthRasterizationField(splat, unfiltered),
        ),
    ]
