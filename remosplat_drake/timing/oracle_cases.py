"""Benchmarks of the construction and the queries of distance oracles.

The scene is a table with cylinders and a wall, represented by surfels. The 77
spheres are arranged like those of a robot in front of the table. All random
numbers have fixed seeds. The benchmarks of unseen space use that of the shipped
table.
"""

from functools import partial

import numpy as np

from remosplat_drake.base import resources
from remosplat_drake.oracle.kernels.ellipsoid_distance import CONVERGE
from remosplat_drake.oracle.kernels.nearest_splat import query_every_splat
from remosplat_drake.oracle.prepared_solids import splat_records
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.reconstruction.seen_file import read_seen_space, seen_path
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.timing.measuring import Case

MAX_DISTANCE = 0.5
"""Distance up to which queries search for surfaces: the controller's influence
distance [m]."""

_TABLE = "package://remosplat_drake/models/scenes/table/splat.ply"


def oracle_cases() -> list[Case]:
    """Makes benchmarks of queries of 77 spheres in scenes of several sizes.

    One benchmark is brute force, a loop over all splats, for comparison.
    """
    spheres = robot_spheres()
    cases = []
    for n in (10_000, 60_000, 300_000, 1_000_000):
        field = SphereToEllipsoidField(table_scene(n))
        cases.append(
            Case(
                f"oracle: query, {n // 1000}k splats",
                partial(field.clearances, spheres, MAX_DISTANCE),
            )
        )
    splat = table_scene(60_000)
    two = SphereToEllipsoidField(splat, num_threads=2)
    return [
        *cases,
        Case(
            "oracle: query, 60k splats, 2 threads",
            partial(two.clearances, spheres, MAX_DISTANCE),
        ),
        Case(
            "oracle: build, 60k splats",
            partial(SphereToEllipsoidField, splat),
        ),
        *_unknown_space_cases(spheres),
        Case(
            "oracle: brute force, 60k splats, compiled",
            partial(try_every_splat, splat, spheres),
        ),
    ]


def _unknown_space_cases(spheres: Spheres) -> list[Case]:
    """Makes benchmarks of the distance to the shipped table's unseen space."""
    splat = resources.resolve(_TABLE)
    coverage = read_seen_space(seen_path(splat), splat)
    field = unknown_space_field(coverage)
    return [
        Case(
            "oracle: query, unseen space",
            partial(field.clearances, spheres, MAX_DISTANCE),
        ),
        Case(
            "oracle: build, unseen space",
            partial(unknown_space_field, coverage),
        ),
    ]


def try_every_splat(splat: GaussianSplat, spheres: Spheres) -> np.ndarray:
    """Runs a compiled loop over all pairs of spheres and splats."""
    question = np.column_stack(
        [spheres.p_WS, spheres.radius + MAX_DISTANCE, spheres.ignore_below]
    )
    answer = np.empty((len(spheres), 8))
    records, _ = splat_records(splat, min_opacity=0.1, n_sigma=1.0)
    query_every_splat(records, splat.is_surfel, CONVERGE, question, answer)
    return answer


def table_scene(n: int) -> GaussianSplat:
    """Makes a table top, four cylinders on it and a wall: n surfels in W."""
    rng = np.random.default_rng(0)
    part = rng.choice(3, n, p=[0.5, 0.2, 0.3])
    a, b = rng.uniform(-1, 1, (2, n))
    angle = np.pi * a
    corner = rng.choice([-1.0, 1.0], (2, n))
    top = np.stack([1.5 + 0.5 * a, 2 * b, np.full(n, 0.53)], axis=1)
    cylinder = np.stack(
        [
            1.2 + 0.1 * corner[0] + 0.05 * np.cos(angle),
            0.25 * corner[1] + 0.05 * np.sin(angle),
            0.8 + 0.27 * b,
        ],
        axis=1,
    )
    wall = np.stack([np.full(n, 2.0), 2 * a, 1 + b], axis=1)
    zero, one = np.zeros(n), np.ones(n)
    x, y, z = np.choose(
        part,
        [
            np.stack([zero, zero, one]),
            np.stack([np.cos(angle), np.sin(angle), zero]),
            np.stack([-one, zero, zero]),
        ],
    )
    # The rotation has the smallest angle that rotates z to the surface's
    # normal.
    quaternions = np.stack([1 + z, -y, x, zero], axis=1)
    spacing = np.sqrt(8.0 / n)
    return GaussianSplat(
        p_GK=np.choose(part[:, None], [top, cylinder, wall])
        + rng.normal(scale=0.003, size=(n, 3)),
        quaternions=quaternions + rng.normal(scale=0.05, size=(n, 4)),
        scales=spacing * rng.uniform(0.3, 1.2, (n, 2)),
        opacities=rng.uniform(0.02, 1, n),
        colors=rng.uniform(0, 1, (n, 3)),
    )


def robot_spheres() -> Spheres:
    """Places 16 spheres of a base and 61 along an arm over the table."""
    base = np.stack(
        np.meshgrid([-0.2, -0.1, 0.1, 0.2], [-0.12, 0.12], [0.12, 0.26]), -1
    ).reshape(-1, 3)
    bend = [[0.45, 0, 0.38], [0.45, 0, 0.75], [1.0, 0, 1.0], [1.1, 0, 0.66]]
    along = np.linspace(0, 3, 61)
    arm = np.stack(
        [np.interp(along, range(4), np.array(bend)[:, k]) for k in range(3)], 1
    )
    spheres = Spheres.at(
        np.concatenate([base + np.array([0.3, 0, 0]), arm]),
        np.repeat([0.155, 0.07], [16, 61]),
    )
    spheres.ignore_below[:16] = 0.03
    return spheres
