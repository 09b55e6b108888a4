"""Tests of polygons for splats, whole and cut into tiles."""

import copy

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.base.colors import linear_rgb
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_tiles import largest, make_tiles, surfel_mesh

IDENTITY = (1.0, 0.0, 0.0, 0.0)


def make_splat(scales, opacities=None, colors=(0.5, 0.5, 0.5)):
    n = len(scales)
    return GaussianSplat(
        p_GK=np.arange(3 * n).reshape(n, 3),
        quaternions=np.tile(IDENTITY, (n, 1)),
        scales=np.array(scales),
        opacities=np.ones(n) if opacities is None else np.array(opacities),
        colors=np.tile(colors, (n, 1)),
    )


def test_disc_becomes_a_stretched_square():
    # A disc in the xy plane at the origin, scales 0.2 along x, 0.1 along y.
    vertices, faces, _ = surfel_mesh(
        make_splat([[0.2, 0.1]]), n_sigma=2.0, sides=4
    )
    corners = [[0.4, 0, 0], [0, 0.2, 0], [-0.4, 0, 0], [0, -0.2, 0]]
    np.testing.assert_allclose(vertices, np.add(corners, [0, 1, 2]), atol=1e-6)
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_ellipsoid_lies_across_its_shortest_axis():
    vertices, _, _ = surfel_mesh(
        make_splat([[0.2, 0.01, 0.1]]), n_sigma=1.0, sides=6
    )
    np.testing.assert_allclose(vertices[:, 1], 1.0, atol=1e-7)
    assert np.ptp(vertices[:, 0]) == pytest.approx(0.4)


def test_polygons_share_no_vertices_and_lie_in_their_planes():
    rng = np.random.default_rng(3)
    n = 20
    splat = GaussianSplat(
        p_GK=rng.normal(size=(n, 3)),
        quaternions=rng.normal(size=(n, 4)),
        scales=rng.uniform(0.01, 0.1, (n, 2)),
        opacities=np.ones(n),
        colors=rng.uniform(size=(n, 3)),
    )
    vertices, faces, colors = surfel_mesh(splat, n_sigma=1.0, sides=5)
    assert vertices.shape == colors.shape == (5 * n, 3)
    assert faces.shape == (3 * n, 3)
    assert (faces // 5 == faces[:, :1] // 5).all()
    offsets = vertices.reshape(n, 5, 3) - splat.p_GK[:, None]
    normals = splat.R_GK[:, :, 2]
    np.testing.assert_allclose(
        np.einsum("nsx,nx->ns", offsets, normals), 0, atol=1e-9
    )


def test_largest_keeps_what_covers_most():
    splat = make_splat(
        [[0.1, 0.1], [0.3, 0.3], [0.2, 0.2], [0.3, 0.3]],
        opacities=[1.0, 1.0, 1.0, 0.1],
    )
    kept = largest(splat, 2)
    np.testing.assert_array_equal(kept.p_GK, splat.p_GK[[1, 2]])
    assert largest(splat, 4) is splat
    kept = largest(splat, 4, min_opacity=0.5)
    np.testing.assert_array_equal(kept.p_GK, splat.p_GK[:3])


def test_of_equal_splats_the_first_are_kept():
    kept = largest(make_splat([[0.2, 0.1]] * 3 + [[0.2, 0.3]]), 3)
    np.testing.assert_array_equal(kept.p_GK[:, 0], [0, 3, 9])


@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.sampled_from([2, 3]))
def test_largest_are_those_of_a_sorted_list(seed, count, n_scales):
    rng = np.random.default_rng(seed)
    splat = make_splat(
        rng.choice([0.1, 0.2, 0.3], (10, n_scales)), rng.choice([0.2, 0.9], 10)
    )
    faint = np.float32(0.5)
    by_cover = sorted(
        (i for i in range(10) if splat.opacities[i] >= faint),
        key=lambda i: (
            -np.prod(np.sort(splat.scales[i])[-2:]) * splat.opacities[i],
            i,
        ),
    )
    kept = largest(splat, count, 0.5)
    expected = splat.select(np.sort(by_cover[:count]).astype(int))
    np.testing.assert_array_equal(kept.p_GK, expected.p_GK)


def scattered(n: int, **changes) -> GaussianSplat:
    rng = np.random.default_rng(5)
    arrays = {
        "p_GK": rng.uniform(size=(n, 3)),
        "quaternions": np.tile(IDENTITY, (n, 1)),
        "scales": np.full((n, 2), 0.01),
        "opacities": np.ones(n),
        "colors": rng.uniform(size=(n, 3)),
    }
    return GaussianSplat(**(arrays | changes))


def test_tiles_hold_each_disc_once():
    splat = scattered(25)
    order = np.arange(25)[::-1]
    tiles = make_tiles(splat, order, size=10)
    assert [t.vertices.shape for t in tiles] == [(3, 60), (3, 60), (3, 30)]
    assert [t.faces.shape for t in tiles] == [(3, 40), (3, 40), (3, 20)]
    vertices, faces, colors = surfel_mesh(splat.select(order), 1.6)
    np.testing.assert_allclose(
        np.hstack([t.vertices for t in tiles]).T, vertices, atol=1e-6
    )
    np.testing.assert_allclose(
        np.hstack([t.colors for t in tiles]).T, colors, atol=1e-6
    )
    np.testing.assert_array_equal(tiles[1].faces.T, faces[:40])
    assert tiles[0].faces.base is tiles[1].faces.base


def test_tiles_are_read_only_and_not_copied():
    (tile,) = make_tiles(scattered(3))
    assert copy.deepcopy(tile) is tile
    assert tile.vertices.dtype == tile.colors.dtype == np.float32
    for array in (tile.vertices, tile.faces, tile.colors):
        assert not array.flags.writeable


def test_tiles_are_small_without_an_order():
    """1000 points of a unit cube in ten tiles."""
    tiles = make_tiles(scattered(1000), size=100)
    volumes = [np.ptp(t.vertices, axis=1).prod() for t in tiles]
    assert len(tiles) == 10
    assert np.mean(volumes) < 0.5


def test_faint_splats_are_in_no_tile():
    splat = scattered(4, opacities=[0.05, 1.0, 1.0, 0.09])
    (tile,) = make_tiles(splat, np.array([3, 2, 1, 0]))
    shown = splat.select(np.array([2, 1]))
    np.testing.assert_allclose(
        tile.vertices.T, surfel_mesh(shown, 1.6)[0], atol=1e-6
    )
    np.testing.assert_allclose(
        tile.colors[:, 0], 1.5 * linear_rgb(splat.colors[2]), rtol=1e-6
    )


def test_nothing_has_no_tile():
    assert make_tiles(scattered(0)) == ()
    assert make_tiles(scattered(2, opacities=[0.01, 0.02])) == ()
