"""Tests of surfels and points of a splat."""

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization import splat_view
from remosplat_drake.visualization.splat_view import (
    POINTS,
    SURFELS,
    SplatView,
    opaque,
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


def test_splat_is_drawn_below_its_pose(page, pose_of, is_visible):
    X_WG = RigidTransform([1.0, 2.0, 3.0])
    SplatView(page, make_splat([[0.1, 0.1]] * 3), X_WG)
    assert page.meshcat.HasPath(SURFELS) and page.meshcat.HasPath(POINTS)
    np.testing.assert_array_equal(
        pose_of(page.meshcat, "/remosplat/splat"), X_WG.GetAsMatrix4()
    )

    assert is_visible(page.meshcat, SURFELS)
    assert not is_visible(page.meshcat, POINTS)


def test_faint_splats_are_not_drawn(page):
    splat = make_splat([[0.1, 0.1]] * 3, opacities=[0.05, 0.5, 0.9])
    assert len(opaque(splat, 10)) == 2
    SplatView(page, splat.select(np.array([0])))
    assert page.meshcat._GetPackedObject(SURFELS) == b""


def test_a_page_says_how_many_splats_it_shows(page, monkeypatch):
    monkeypatch.setattr(splat_view, "MAX_SURFELS", 2)
    splat = make_splat([[0.1, 0.1]] * 3)
    SplatView(page, splat.select(slice(0, 2)))
    assert "splat" not in page.status
    SplatView(page, splat)
    assert page.status["splat"] == "2 of 3 splats shown"
