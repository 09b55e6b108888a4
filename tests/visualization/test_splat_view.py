"""Tests of surfels and points of a splat."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.splat_view import (
    POINTS,
    SURFELS,
    SplatView,
    largest,
    surfel_mesh,
)

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


def test_splat_is_drawn_below_its_pose(page, pose_of, click, is_visible):
    X_WG = RigidTransform([1.0, 2.0, 3.0])
    dut = SplatView(page, make_splat([[0.1, 0.1]] * 3), X_WG)
    assert page.meshcat.HasPath(SURFELS) and page.meshcat.HasPath(POINTS)
    np.testing.assert_array_equal(
        pose_of(page.meshcat, "/remosplat/splat"), X_WG.GetAsMatrix4()
    )

    click(page.meshcat, "Splat: surfels / points / off")
    page.poll()
    assert is_visible(page.meshcat, POINTS)
    assert not is_visible(page.meshcat, SURFELS)

    # Another map does not undo the user's choice.
    dut.draw(make_splat([[0.1, 0.1]]))
    assert not is_visible(page.meshcat, SURFELS)


def test_faint_splats_are_not_drawn(page):
    splat = make_splat([[0.1, 0.1]] * 3, opacities=[0.05, 0.5, 0.9])
    dut = SplatView(page, splat)
    size = len(page.meshcat._GetPackedObject(SURFELS))
    dut.draw(splat.select(np.array([1, 2])))
    assert len(page.meshcat._GetPackedObject(SURFELS)) == size
    dut.draw(splat.select(np.array([0])))
    assert len(page.meshcat._GetPackedObject(SURFELS)) < size
