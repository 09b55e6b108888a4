"""Content of a map around some places, counted fast and counted simply."""

import dataclasses as dc
import time

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.oracle.map_summary import (
    MapSummary,
    Place,
    least_opacity,
    summarize_solids,
    summarize_splat,
)
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    SphereToEllipsoid,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

PLACES = {"the start": np.zeros(3), "target 1": np.array([2.0, 0.5, 1.0])}
REACH = 1.2


def random_splat(
    n: int = 5000, seed: int = 0, spread: float = 3
) -> GaussianSplat:
    rng = np.random.default_rng(seed)
    return GaussianSplat(
        p_GK=rng.uniform(-spread, spread, (n, 3)),
        quaternions=rng.normal(size=(n, 4)),
        scales=np.full((n, 2), 0.01),
        opacities=rng.uniform(0.01, 1, n),
        colors=np.full((n, 3), 0.5),
    )


def summary(
    splat_W: GaussianSplat,
    cropped_W: GaussianSplat | None = None,
    oracle: SphereToEllipsoid | DepthRasterization | None = None,
    floor_height: float = -np.inf,
) -> MapSummary:
    return summarize_splat(
        splat_W,
        cropped_W or GaussianSplat.empty(),
        oracle or SphereToEllipsoid(min_opacity=0.3),
        PLACES,
        reach=REACH,
        floor_height=floor_height,
    )


def is_near(splat_W: GaussianSplat) -> np.ndarray:
    """Which splats are within reach of which place, the simple way."""
    p_WK = splat_W.p_GK.astype(float)
    return np.array(
        [
            np.linalg.norm(p_WK - p_WP, axis=1) <= REACH
            for p_WP in PLACES.values()
        ]
    )


def test_counts_are_those_of_counting():
    splat, cropped = random_splat(), random_splat(3000, seed=1)
    told = summary(splat, cropped, floor_height=-0.5)
    opaque = splat.opacities >= 0.3
    assert (told.kept, told.faint) == (opaque.sum(), (~opaque).sum())
    assert told.cropped == 3000
    counts = (is_near(splat) & opaque).sum(axis=1)
    assert [p.within_reach for p in told.places] == counts.tolist()
    assert [p.name for p in told.places] == list(PLACES)
    near = is_near(splat).any(axis=0) & (splat.p_GK[:, 2] >= -0.5)
    lost = is_near(cropped).any(axis=0) & (cropped.p_GK[:, 2] >= -0.5)
    ignored = (near & ~opaque).sum() + lost.sum()
    assert told.ignored == pytest.approx(ignored / (near.sum() + lost.sum()))
    weight = splat.opacities[near & ~opaque].sum()
    weight += cropped.opacities[lost].sum()
    total = splat.opacities[near].sum() + cropped.opacities[lost].sum()
    assert told.ignored_opacity == pytest.approx(weight / total)


def test_it_fits_into_a_line():
    line = str(summary(random_splat(), random_splat(1234)))
    assert "1,234 cropped away; within 1.2 m of the start" in line
    assert "\n" not in line


def test_many_targets_fit_into_a_line():
    near = [5, 40, 30, 20, 1000, 2000]
    names = ["the start", *(f"target {i}" for i in range(1, 6))]
    places = tuple(map(Place, names, near))
    line = str(MapSummary("splats", 9000, 0, 0, 1.2, places))
    assert line.endswith(
        "within 1.2 m of the start: 5, of target 1: 40, of target 2: 30, of"
        " target 3: 20, of each of 2 other targets: 1,000 to 2,000"
    )
    line = str(MapSummary("splats", 9000, 0, 0, 1.2, places[:5]))
    assert line.endswith("of target 3: 20, of target 4: 1,000")


def test_a_map_far_away_holds_nothing_here():
    splat = random_splat().transformed(RigidTransform([1e4, 0, 0]))
    told = summary(splat)
    assert told.kept > 3000
    assert [p.within_reach for p in told.places] == [0, 0]
    assert told.ignored == told.ignored_opacity == 0


@pytest.mark.filterwarnings("error")
def test_splats_out_of_this_world_are_not_within_reach():
    splat = random_splat(spread=1e30)
    assert [p.within_reach for p in summary(splat).places] == [0, 0]


def test_an_empty_map_is_empty():
    told = summary(GaussianSplat.empty())
    assert (told.kept, told.faint, told.ignored) == (0, 0, 0)
    assert [p.within_reach for p in told.places] == [0, 0]


def test_a_floor_that_is_cropped_away_is_no_loss():
    splat = random_splat()
    below = splat.p_GK[:, 2] < 0
    told = summary(
        splat.select(~below),
        splat.select(below),
        SphereToEllipsoid(min_opacity=0.0),
        floor_height=0.0,
    )
    assert told.cropped == below.sum()
    assert told.ignored == told.ignored_opacity == 0


def test_depth_views_see_what_ten_layers_make_opaque():
    sensor = DepthRasterization(alpha_cutoff=0.7)
    alpha = least_opacity(sensor)
    assert 1 - (1 - alpha) ** 10 == pytest.approx(0.7)
    splat = random_splat()
    told = summary(splat, oracle=sensor)
    assert told.kept == np.count_nonzero(splat.opacities >= alpha)
    faint = dc.replace(splat, opacities=np.full(len(splat), 0.05))
    assert summary(faint, oracle=sensor).kept == 0


def test_solids_count_where_their_surface_is_within_reach():
    def box(x: float) -> Box:
        return Box(RigidTransform([x, 0, 0]), np.full(3, 0.5))

    # Their faces are 1.1 and 1.3 m before the start; the second is within
    # reach of the target alone.
    scene = PrimitiveScene(boxes=(box(-1.6), box(1.8), box(9)))
    told = summarize_solids(scene, PLACES, REACH)
    assert told.kept == 3
    assert [p.within_reach for p in told.places] == [1, 1]
    assert "3 solids; within 1.2 m of the start: 1, of target 1: 1" in str(told)


def test_a_million_splats_take_a_moment():
    splat = random_splat(1_000_000)

    def seconds() -> float:
        # Of this thread: others may be at work on this computer.
        start = time.thread_time()
        summary(splat)
        return time.thread_time() - start

    assert min(seconds() for _ in range(3)) < 0.05
