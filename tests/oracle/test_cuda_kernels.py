"""The CUDA kernels, run on the CPU, against the CPU's kernels."""

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.oracle.cuda.clusters import (
    CLUSTER,
    make_clusters,
    split_positions,
)
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import R_DV, DepthSensor
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from tests.oracle.cuda_on_host import (
    nearest_pixels,
    nearest_solids,
    needs_compiler,
)
from tests.oracle.toy_views import (
    assert_equal_but_for_rounding,
    random_spheres,
    random_splat,
)

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.integers(1, 3000))
@settings(max_examples=20, deadline=None)
def test_boxes_hold_what_is_in_them(seed, n):
    rng = np.random.default_rng(seed)
    records = rng.normal(size=(n, 16)) * rng.choice([0.1, 100.0])
    half = rng.exponential(size=(n, 3)) ** 4
    index = rng.permutation(n)
    made = make_clusters(records, half, index)
    np.testing.assert_array_equal(np.sort(made.order), np.arange(n))
    order = np.argsort(index)[made.order]
    np.testing.assert_array_equal(made.records, records[order].astype("f4"))
    center, half = records[order, :3], half[order]
    for boxes, size in ((made.clusters, CLUSTER), (made.groups, CLUSTER**2)):
        assert len(boxes) == -(-n // size)
        box = boxes[np.arange(n) // size].astype(float)
        assert (box[:, :3] <= center - half).all()
        assert (box[:, 4:7] >= center + half).all()
        assert (box[:, 3] >= center[:, 2]).all()


def test_a_split_position_keeps_what_single_precision_loses():
    p_WS = np.array([[123.456789012, -0.1, 1e-9]])
    split = split_positions(p_WS).astype(float)
    np.testing.assert_allclose(split[:, :3] + split[:, 3:], p_WS, atol=1e-12)


@needs_compiler
@given(seeds, st.sampled_from([1, 7, 40, 1500]), st.booleans(), st.booleans())
@settings(max_examples=effort(10, 40), deadline=None)
def test_solids_are_as_far_as_on_the_cpu(seed, n, flat, uncertain):
    rng = np.random.default_rng(seed)
    splat = random_splat(rng, n, 2 if flat else 3, uncertain=uncertain)
    spheres = random_spheres(rng, 12)
    limit = float(rng.choice([0.05, 0.3, np.inf]))
    field = SphereToEllipsoidField(splat, min_opacity=0.0)
    expected = field.clearances(spheres, limit)
    found = nearest_solids(splat, spheres, limit)
    distance = np.where(found[:, 0] < 1e30, found[:, 0], np.inf)
    distance -= spheres.radius
    far = expected.per_sphere(12)
    with np.errstate(invalid="ignore"):
        close = np.abs(distance - far) < 2e-6
    # One that is just as far as is asked for may be left out, or not.
    edge = np.minimum(distance, far) > limit - 2e-6
    assert (close | edge | (distance == far)).all()
    # Direction and point belong together, and to that distance.
    seen = found[:, 0] < 1e30
    to, n_W = found[seen, 1:4], found[seen, 4:7]
    np.testing.assert_allclose(np.linalg.norm(n_W, axis=1), 1, atol=1e-5)
    length = np.linalg.norm(to, axis=1)
    away = length > 1e-3
    np.testing.assert_allclose(
        np.abs((to * n_W).sum(axis=1))[away], length[away], rtol=1e-4
    )


@needs_compiler
def test_directions_are_those_of_the_cpu():
    rng = np.random.default_rng(3)
    for n_scales in (2, 3):
        splat = random_splat(rng, 300, n_scales)
        spheres = random_spheres(rng, 60)
        field = SphereToEllipsoidField(splat, min_opacity=0.0)
        expected = field.clearances(spheres)
        found = nearest_solids(splat, spheres, np.inf)
        np.testing.assert_allclose(
            found[:, 4:7], expected.direction_W, atol=1e-3
        )
        np.testing.assert_allclose(
            spheres.p_WS + found[:, 1:4], expected.p_WC, atol=1e-5
        )


@needs_compiler
@pytest.mark.parametrize("thickness", [1e-8, 1e-4, 1.0, 1e3])
def test_needles_and_flakes(thickness):
    """Semi-axes of very different lengths, looked at from all sides."""
    rng = np.random.default_rng(0)
    scales = np.array([[0.2, 0.2 * min(thickness, 1.0), 0.1 * thickness]])
    splat = GaussianSplat(
        np.array([[10.0, -20.0, 5.0]]),
        rng.normal(size=(1, 4)),
        np.maximum(scales, 1e-9),
        np.ones(1),
        np.zeros((1, 3)),
    )
    spheres = Spheres.at(splat.p_GK + rng.normal(scale=0.3, size=(200, 3)))
    field = SphereToEllipsoidField(splat)
    expected = field.clearances(spheres)
    found = nearest_solids(splat, spheres, np.inf)
    size = max(0.3, float(scales.max()))
    np.testing.assert_allclose(found[:, 0], expected.distance, atol=2e-6 * size)


@needs_compiler
@given(
    seeds,
    st.sampled_from([1, 15, 60, 250]),
    st.booleans(),
    st.booleans(),
    st.sampled_from([5, 24, 80]),
)
@settings(max_examples=15, deadline=None)
def test_views_see_what_the_cpu_sees(seed, n, flat, uncertain, resolution):
    rng = np.random.default_rng(seed)
    splat = random_splat(rng, n, 2 if flat else 3, uncertain=uncertain)
    spheres = random_spheres(rng, 3)
    sensor = DepthSensor(
        resolution=resolution,
        alpha_cutoff=float(rng.choice([0.55, 0.7, 0.95])),
        near=float(rng.choice([0.001, 0.05])),
        orientation=str(rng.choice(["link", "world"])),
    )
    limit = float(rng.choice([0.1, 0.5, np.inf]))
    found, pixel, _ = nearest_pixels(splat, spheres, limit, sensor)
    assert ((pixel >= 0) == np.isfinite(found)).all()
    assert_equal_but_for_rounding(found, splat, spheres, sensor, limit)


@needs_compiler
def test_little_room_changes_nothing():
    """Fragments that do not fit are listed in turns."""
    rng = np.random.default_rng(1)
    splat, spheres = random_splat(rng, 300, 2, 0.1), random_spheres(rng, 3)
    sensor = DepthSensor(resolution=40)
    found = nearest_pixels(splat, spheres, np.inf, sensor)
    again = nearest_pixels(splat, spheres, np.inf, sensor, room=60)
    for left, right in zip(found, again, strict=True):
        np.testing.assert_array_equal(left, right)


@needs_compiler
def test_narrow_bands_change_nothing():
    rng = np.random.default_rng(2)
    splat, spheres = random_splat(rng, 100, 2, 0.1), random_spheres(rng, 3)
    sensor = DepthSensor(resolution=37)
    found = nearest_pixels(splat, spheres, 0.3, sensor)
    again = nearest_pixels(splat, spheres, 0.3, sensor, band=100)
    for left, right in zip(found, again, strict=True):
        np.testing.assert_array_equal(left, right)


@needs_compiler
def test_too_many_fragments_on_one_ray_to_be_listed():
    x = np.linspace(0.2, 0.25, 80)
    p_WK = np.stack([x, 0 * x, 0 * x], axis=1)
    half = np.sqrt(0.5)
    veils = GaussianSplat(
        p_WK,
        np.tile([half, 0, half, 0], (80, 1)),
        np.full((80, 2), 0.2),
        np.full(80, 0.02),
        np.zeros((80, 3)),
    )
    sensor, sphere = DepthSensor(resolution=9), Spheres.at(np.zeros(3))
    exact, pixel, _ = nearest_pixels(veils, sphere, np.inf, sensor)
    short, other, _ = nearest_pixels(veils, sphere, np.inf, sensor, room=8)
    assert exact.min() == pytest.approx(0.2215, abs=1e-3)
    np.testing.assert_allclose(short, exact, rtol=0, atol=1e-7)
    np.testing.assert_array_equal(other, pixel)


@needs_compiler
def test_what_lies_far_behind_makes_a_pixel_count():
    """A veil that lets too much pass is near only where a wall is behind it."""
    half = np.sqrt(0.5)
    discs = GaussianSplat(
        np.array([[0.3, 0, 0], [0.85, 0, 0]]),
        np.tile([half, 0, half, 0], (2, 1)),
        np.array([[0.05, 0.05], [1.0, 1.0]]),
        np.array([0.6, 0.9]),
        np.zeros((2, 3)),
    )
    front, wall = discs.select(slice(0, 1)), discs.select(slice(1, 2))
    sensor, sphere = DepthSensor(resolution=41), Spheres.at(np.zeros(3))
    view = int(np.flatnonzero(R_DV[:, 0, 2] == 1)[0])
    for room in (4096, 1):
        found = [
            nearest_pixels(splat, sphere, np.inf, sensor, room=room)[0][0, view]
            for splat in (discs, front, wall)
        ]
        np.testing.assert_allclose(found, [0.3, np.inf, 0.85], atol=1e-6)


@needs_compiler
def test_rows_of_the_nearest_view_only():
    rng = np.random.default_rng(5)
    splat, spheres = random_splat(rng, 200, 2, 0.1), random_spheres(rng, 4)
    sensor = DepthSensor(resolution=24)
    every, _, rows = nearest_pixels(splat, spheres, 0.4, sensor)
    _, _, nearest = nearest_pixels(splat, spheres, 0.4, sensor, True)
    np.testing.assert_array_equal(rows[..., 0], every.astype(np.float32))
    np.testing.assert_array_equal(
        nearest[..., 0].min(axis=1), every.min(axis=1).astype(np.float32)
    )
    assert (np.isfinite(nearest[..., 0]).sum(axis=1) <= 1).all()
    field = DepthRasterizationField(splat, sensor)
    expected = field.clearances(spheres, 0.4)
    seen = np.isfinite(rows[..., 0])
    assert seen.sum() == len(expected) > 5
    np.testing.assert_allclose(
        rows[seen][:, 1:], expected.direction_W, atol=1e-5
    )


@needs_compiler
def test_one_disc_worked_by_hand():
    half = np.sqrt(0.5)
    disc = GaussianSplat(
        np.array([[0.3, 0, 0]]),
        np.array([[half, 0, half, 0]]),
        np.full((1, 2), 0.05),
        np.array([0.95]),
        np.zeros((1, 3)),
    )
    sensor = DepthSensor(resolution=41)
    found, pixel, rows = nearest_pixels(
        disc, Spheres.at(np.zeros(3), 0.1), np.inf, sensor
    )
    view = int(np.flatnonzero(R_DV[:, 0, 2] == 1)[0])
    assert found[0, view] == pytest.approx(0.3)
    assert pixel[0, view] == 20 * 41 + 20
    np.testing.assert_allclose(rows[0, view], [0.3, 1, 0, 0], atol=1e-6)
    others = np.arange(6) != view
    assert np.isinf(found[0, others]).all()
