"""Images to look at: the reference's images, and the oracle's answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.oracle import depth_rasterization_reference as reference
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import R_DV, DepthSensor
from remosplat_drake.oracle.view_images import look_around, render
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def random_splat(rng: np.random.Generator, n_scales: int) -> GaussianSplat:
    n = 60
    return GaussianSplat(
        p_GK=rng.uniform(-0.5, 0.5, (n, 3)),
        quaternions=rng.normal(size=(n, 4)),
        scales=np.exp(rng.uniform(np.log(0.005), np.log(0.3), (n, n_scales))),
        opacities=rng.uniform(0.002, 1.0, n),
        colors=np.zeros((n, 3)),
    )


def random_sphere(rng: np.random.Generator, ignore_below: float) -> Spheres:
    R_WL = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Spheres(
        rng.uniform(-0.5, 0.5, (1, 3)),
        (R_WL * np.linalg.det(R_WL))[None],
        np.array([0.05]),
        np.array([ignore_below]),
    )


@given(
    seed=st.integers(0, 2**32 - 1),
    n_scales=st.sampled_from([2, 3]),
    filtered=st.booleans(),
    floor=st.sampled_from([-np.inf, -0.1]),
)
@settings(max_examples=12)
def test_images_equal_the_reference(seed, n_scales, filtered, floor):
    rng = np.random.default_rng(seed)
    splat = random_splat(rng, n_scales)
    sensor = DepthSensor(resolution=12, low_pass_filter=filtered)
    sphere = random_sphere(rng, floor)
    p_WS, R_WD = sphere.p_WS[0], sphere.R_WL[0]
    images = render(splat, p_WS, R_WD, sensor, floor)
    expected = reference.render(splat, p_WS, R_WD, sensor, ignore_below=floor)
    np.testing.assert_allclose(images.alpha, expected.alpha, atol=1e-5)
    np.testing.assert_allclose(images.depth, expected.depth, rtol=1e-5)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=12)
def test_nearest_pixels_are_the_oracle_s_answer(seed):
    rng = np.random.default_rng(seed)
    splat, sphere = random_splat(rng, 2), random_sphere(rng, -np.inf)
    sensor = DepthSensor(resolution=20)
    views = look_around(splat, sensor, sphere, 0)
    answer = DepthRasterizationField(splat, sensor).clearances(sphere)
    seen = np.isfinite(views.clearances)
    np.testing.assert_allclose(
        views.clearances[seen], answer.distance, rtol=1e-5
    )
    np.testing.assert_allclose(
        views.nearest_points[seen], answer.p_WC, atol=1e-5
    )


def test_a_wall_is_seen_by_the_view_that_faces_it():
    # An opaque disc of 10 m in the plane x = 0.5, normal to x.
    wall = GaussianSplat(
        p_GK=[[0.5, 0, 0]],
        quaternions=[[np.sqrt(0.5), 0, np.sqrt(0.5), 0]],
        scales=[[10, 10]],
        opacities=[0.99],
        colors=[[0, 0, 0]],
    )
    sensor = DepthSensor(resolution=5)
    views = look_around(wall, sensor, Spheres.at(np.zeros(3), 0.1), 0)
    facing = int((R_DV[:, :, 2] @ [1, 0, 0]).argmax())
    np.testing.assert_allclose(views.images.depth[facing], 0.5, atol=1e-6)
    np.testing.assert_array_equal(views.nearest[facing], [2, 2])
    assert views.clearances[facing] == pytest.approx(0.4)
    np.testing.assert_allclose(
        views.nearest_points[facing], [0.5, 0, 0], atol=1e-6
    )
    # The opposite view sees nothing.
    behind = int((R_DV[:, :, 2] @ [1, 0, 0]).argmin())
    assert views.clearances[behind] == np.inf
