"""The CUDA backend of the depth views against the CPU's, on a CUDA device."""

import numpy as np
import pytest

from remosplat_drake.oracle.backend import missing_for_gsplat
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_rasterization_gsplat import GsplatDepthField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat

pytestmark = pytest.mark.gpu

GSPLAT_OUTLINE = np.sqrt(2 * np.log(255))
"""Standard deviations at which an opaque disc's alpha is 1/255."""


@pytest.fixture(autouse=True, scope="module")
def cuda():
    problem = missing_for_gsplat()
    if problem:
        pytest.skip(f"the CUDA backend {problem}")


def _splat(rng, n, largest) -> GaussianSplat:
    return GaussianSplat(
        rng.uniform(-0.5, 0.5, (n, 3)),
        rng.normal(size=(n, 4)),
        np.exp(rng.uniform(np.log(0.003), np.log(largest), (n, 2))),
        rng.uniform(0.2, 1.0, n),
        np.zeros((n, 3)),
    )


def _spheres(rng, n) -> Spheres:
    R_WL = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    R_WL *= np.linalg.det(R_WL)[:, None, None]
    p_WS = rng.uniform(-0.5, 0.5, (n, 3))
    ignore_below = rng.choice([-np.inf, -0.1], n)
    return Spheres(p_WS, R_WL, rng.uniform(0.02, 0.1, n), ignore_below)


def _wall(x, opacity, scale=0.1) -> GaussianSplat:
    """A disc that faces the x axis, at a distance x."""
    half = np.sqrt(0.5)
    return GaussianSplat(
        np.array([[x, 0, 0]]),
        np.array([[half, 0, half, 0]]),
        np.full((1, 2), scale),
        np.array([opacity]),
        np.zeros((1, 3)),
    )


@pytest.mark.parametrize("low_pass_filter", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_discs_that_hardly_overlap_are_seen_as_on_the_cpu(
    seed, low_pass_filter
):
    rng = np.random.default_rng(seed)
    splat, spheres = _splat(rng, 400, 0.02), _spheres(rng, 20)
    sensor = DepthSensor(
        n_sigma=GSPLAT_OUTLINE, low_pass_filter=low_pass_filter
    )
    expected = DepthRasterizationField(splat, sensor).clearances(spheres, 0.4)
    answer = GsplatDepthField(splat, sensor).clearances(spheres, 0.4)
    np.testing.assert_array_equal(answer.sphere, expected.sphere)
    difference = np.abs(answer.distance - expected.distance)
    assert np.mean(difference > 1e-5) < 0.05
    same = difference < 1e-5
    np.testing.assert_allclose(
        answer.p_WC[same], expected.p_WC[same], atol=1e-5
    )


def test_a_disc_whose_centre_is_beside_the_camera_leaves_no_hole():
    # The views along y and z have its centre at depth 0, and see its rim.
    wall, sphere = _wall(0.1, 0.99, scale=0.3), Spheres.at(np.zeros(3))
    sensor = DepthSensor(resolution=41, n_sigma=GSPLAT_OUTLINE)
    answer = GsplatDepthField(wall, sensor).clearances(sphere)
    expected = DepthRasterizationField(wall, sensor).clearances(sphere)
    assert len(answer) == len(expected) == 5
    np.testing.assert_allclose(answer.distance, expected.distance, atol=1e-5)


def test_a_far_wall_completes_a_near_pixel():
    near, wall = _wall(0.2, 0.6), _wall(0.8, 0.6)
    both = GaussianSplat(
        *(
            np.concatenate([getattr(near, name), getattr(wall, name)])
            for name in ("p_GK", "quaternions", "scales", "opacities", "colors")
        )
    )
    sphere, sensor = Spheres.at(np.zeros(3)), DepthSensor(resolution=41)
    answer = GsplatDepthField(both, sensor).clearances(sphere, 0.3)
    np.testing.assert_allclose(answer.distance, [0.2], atol=1e-6)
    assert len(GsplatDepthField(near, sensor).clearances(sphere, 0.3)) == 0


def test_the_nearest_view_only_and_what_lies_below():
    rng = np.random.default_rng(0)
    splat, spheres = _splat(rng, 400, 0.02), _spheres(rng, 20)
    every = GsplatDepthField(splat).clearances(spheres)
    nearest = GsplatDepthField(splat, nearest_only=True).clearances(spheres)
    np.testing.assert_array_equal(nearest.per_sphere(20), every.per_sphere(20))
    assert len(nearest) == len(set(every.sphere.tolist()))
    floor = _wall(0.2, 0.95)
    blind = Spheres.at(np.zeros(3), ignore_below=0.1)
    assert len(GsplatDepthField(floor).clearances(blind)) == 0


def test_uncertain_discs_are_seen_as_on_the_cpu():
    # The one behind may be the one in front, beyond the queried distance and
    # the far plane too.
    near, wall = _wall(0.5, 0.95), _wall(0.95, 0.95)
    both = near.with_uncertainty(0.1).joined_with(wall.with_uncertainty(0.7))
    sphere = Spheres.at(np.zeros(3))
    sensor = DepthSensor(resolution=41, n_sigma=GSPLAT_OUTLINE, far=0.9)
    answer = GsplatDepthField(both, sensor).clearances(sphere, 0.3)
    np.testing.assert_allclose(answer.distance, [0.25], atol=1e-5)
    ignoring = GsplatDepthField(both, sensor, subtract_uncertainty=False)
    answer = ignoring.clearances(sphere)
    np.testing.assert_allclose(answer.distance, [0.5], atol=1e-5)
    rng = np.random.default_rng(1)
    splat, spheres = _splat(rng, 400, 0.02), _spheres(rng, 20)
    splat = splat.with_uncertainty(rng.uniform(0, 0.05, 400))
    sensor = DepthSensor(n_sigma=GSPLAT_OUTLINE)
    expected = DepthRasterizationField(splat, sensor).clearances(spheres, 0.4)
    answer = GsplatDepthField(splat, sensor).clearances(spheres, 0.4)
    np.testing.assert_array_equal(answer.sphere, expected.sphere)
    difference = np.abs(answer.distance - expected.distance)
    assert np.mean(difference > 1e-5) < 0.1


def test_no_spheres_and_no_discs():
    field = GsplatDepthField(_wall(0.2, 0.95))
    assert len(field.clearances(Spheres.at(np.zeros((0, 3))))) == 0
    far_off = Spheres.at(np.array([9.0, 0, 0]))
    assert len(field.clearances(far_off, 0.5)) == 0
    assert len(GsplatDepthField(_wall(0.2, 0.003)).clearances(far_off)) == 0
