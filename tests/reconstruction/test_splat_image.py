"""Images of splats: worked by hand, and against the slow definition."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.reconstruction.report import splat_image_reference
from remosplat_drake.reconstruction.report.splat_image import SplatRenderer
from remosplat_drake.splat.gaussian_splat import GaussianSplat

K = np.array([[20.0, 0, 12], [0, 22, 9], [0, 0, 1]])
SIZE = (18, 25)
AT_ORIGIN = np.eye(4)


def _discs(depths, opacities, colors, scale=10.0) -> GaussianSplat:
    """Wide discs that face a camera at the origin."""
    n = len(depths)
    p_GK = np.zeros((n, 3))
    p_GK[:, 2] = depths
    return GaussianSplat(
        p_GK=p_GK,
        quaternions=np.tile([1.0, 0, 0, 0], (n, 1)),
        scales=np.full((n, 2), scale),
        opacities=np.array(opacities),
        colors=np.array(colors, float),
    )


def test_two_veils_by_hand():
    """Red of opacity 0.4 before green of 0.8: 0.4 red, 0.48 green."""
    splat = _discs([2, 1], [0.8, 0.4], [[0, 1, 0], [1, 0, 0]])
    image = SplatRenderer(splat).render(K, AT_ORIGIN, SIZE)
    # Pixel (11.5, 8.5) looks half a pixel past the discs' centres.
    np.testing.assert_allclose(
        image.color[8, 11], [0.4, 0.48, 0], rtol=0, atol=1e-4
    )
    assert image.alpha[8, 11] == pytest.approx(0.88, abs=1e-4)
    assert image.depth[8, 11] == pytest.approx(2)


def test_a_thin_veil_has_no_depth():
    splat = _discs([1], [0.49], [[1, 1, 1]])
    image = SplatRenderer(splat).render(K, AT_ORIGIN, SIZE)
    assert image.depth.max() == 0
    assert image.alpha[8, 11] == pytest.approx(0.49, abs=1e-4)


def test_a_slanted_disc_has_the_depth_of_its_plane():
    """The plane z = 2 + x, seen along x / z = (u - 12) / 20."""
    R = RollPitchYaw(0, -np.pi / 4, 0).ToQuaternion().wxyz()
    splat = GaussianSplat(
        p_GK=np.array([[0.0, 0, 2]]),
        quaternions=R[None],
        scales=np.full((1, 2), 10.0),
        opacities=np.ones(1),
        colors=np.ones((1, 3)),
    )
    image = SplatRenderer(splat, low_pass_filter=False).render(
        K, AT_ORIGIN, SIZE
    )
    x = (np.arange(SIZE[1]) + 0.5 - 12) / 20
    np.testing.assert_allclose(image.depth[9], 2 / (1 - x), rtol=1e-5)


def test_the_filter_keeps_a_speck_visible():
    speck = _discs([1], [1.0], [[1, 1, 1]], scale=1e-4)
    plain = SplatRenderer(speck, low_pass_filter=False)
    assert plain.render(K, AT_ORIGIN, SIZE).alpha.max() == 0
    image = SplatRenderer(speck).render(K, AT_ORIGIN, SIZE)
    # Half a pixel off in both directions: weight 2 (1/4 + 1/4).
    assert image.alpha[8, 11] == pytest.approx(np.exp(-0.5))


def test_an_empty_splat_is_black():
    empty = _discs([], [], np.zeros((0, 3)))
    image = SplatRenderer(empty).render(K, AT_ORIGIN, SIZE)
    assert image.color.shape == (*SIZE, 3)
    assert image.alpha.max() == 0


@settings(max_examples=15)
@given(
    seed=st.integers(0, 2**16),
    axes=st.sampled_from([2, 3]),
    low_pass_filter=st.booleans(),
)
def test_equals_the_reference(seed, axes, low_pass_filter):
    """Splats before, beside, around and behind an oddly placed camera."""
    rng = np.random.default_rng(seed)
    n = 30
    splat = GaussianSplat(
        p_GK=rng.uniform(-1, 1, (n, 3)) * [1.5, 1.5, 2.5],
        quaternions=rng.normal(size=(n, 4)),
        scales=np.exp(rng.uniform(-5, -0.5, (n, axes))),
        opacities=rng.uniform(0.05, 1, n),
        colors=rng.uniform(0, 1, (n, 3)),
    )
    X_WC = RigidTransform(
        RollPitchYaw(rng.uniform(-1, 1, 3)), rng.uniform(-0.3, 0.3, 3)
    ).GetAsMatrix4()
    image = SplatRenderer(splat, low_pass_filter=low_pass_filter).render(
        K, X_WC, SIZE
    )
    expected = splat_image_reference.render(
        splat, K, X_WC, SIZE, low_pass_filter
    )
    for name in ("color", "alpha", "depth"):
        np.testing.assert_allclose(
            getattr(image, name), getattr(expected, name), rtol=0, atol=2e-5
        )
