"""Shapes around points of objects, worked by hand and at random."""

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.fitted_solid import fit_solid
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder

MARGIN = 0.001
"""The shape exceeds the points by this [m]."""


def turned(points, yaw, at):
    c, s = np.cos(yaw), np.sin(yaw)
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + at


def box_points(x, y, z, n=9):
    """Points on the upper half of a box on z = 0, and at its foot."""
    rows = np.linspace(-1.0, 1.0, n)
    u, v = (each.ravel() for each in np.meshgrid(rows, rows))
    one = np.ones_like(u)
    sides = [[u, v, one], [u, one, v], [u, -one, v], [one, u, v], [-one, u, v]]
    points = np.concatenate([np.stack(side, axis=1) for side in sides])
    return np.add(points, [0, 0, 1]) * [0.5 * x, 0.5 * y, 0.5 * z]


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.2, -0.7])
def test_a_box_is_found_with_its_yaw(yaw):
    points = turned(box_points(0.06, 0.1, 0.2), yaw, [1.0, 2.0, 0.5])
    solid = fit_solid(points, 0.5, "milk")
    assert isinstance(solid, Box) and solid.name == "milk"
    half = solid.half_extents
    np.testing.assert_allclose(np.sort(half[:2]), [0.03, 0.05], atol=0.0015)
    assert half[2] == pytest.approx(0.1 + 0.5 * MARGIN)
    p_WP = [1.0, 2.0, 0.6 + 0.5 * MARGIN]
    np.testing.assert_allclose(solid.X_WP.translation(), p_WP, atol=1e-9)
    x_W = solid.X_WP.rotation().matrix()[:, 0]
    off = (np.arctan2(x_W[1], x_W[0]) - yaw) % (0.5 * np.pi)
    assert min(off, 0.5 * np.pi - off) < 0.02


def test_a_can_is_found_although_its_foot_is_not_seen():
    turns = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    ring = 0.03 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    heights = np.linspace(0.02, 0.12, 12)[:, None, None] * [0, 0, 1]
    points = np.add((ring + heights).reshape(-1, 3), [0.3, -0.2, 0.7])
    solid = fit_solid(points, 0.7)
    assert isinstance(solid, Cylinder)
    assert 0.03 + 0.5 * MARGIN < solid.radius < 0.03 + 1.5 * MARGIN
    assert solid.half_height == pytest.approx(0.06 + 0.5 * MARGIN)
    p_WP = [0.3, -0.2, 0.76 + 0.5 * MARGIN]
    np.testing.assert_allclose(solid.X_WP.translation(), p_WP, atol=1e-4)


def test_a_cone_becomes_a_hull():
    turns = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)
    points = [
        0.05 * (1.0 - h) * ring + [0.0, 0.0, 0.12 * h]
        for h in np.linspace(0.1, 1.0, 20)
    ]
    solid = fit_solid(np.concatenate(points), 0.0, "cone")
    assert isinstance(solid, ConvexHull) and solid.name == "cone"
    assert solid.top == pytest.approx(0.12 + MARGIN)


def test_one_side_alone_is_no_shape():
    rng = np.random.default_rng(1)
    side = rng.uniform([0.0, 0.0, 0.1], [0.1, 0.001, 0.2], (200, 3))
    with pytest.raises(RemoSplatError, match="shows only one side of it"):
        fit_solid(side, 0.1)


@given(
    st.integers(0, 10**6),
    st.sampled_from(["ball", "box", "cloud", "two"]),
    st.floats(0.01, 0.3),
)
@settings(max_examples=effort(25, 400), deadline=None)
def test_each_shape_contains_its_points_and_reaches_the_support(
    seed, kind, size
):
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((rng.integers(10, 200), 3))
    if kind == "ball":
        points /= np.linalg.norm(points, axis=1)[:, None]
    elif kind == "box":
        points = rng.uniform(-1, 1, points.shape) * [1.0, 0.4, 0.7]
    elif kind == "two":
        points[::2] += [3.0, 0.0, 0.0]
    points = turned(size * points, rng.uniform(-4, 4), rng.uniform(-2, 2, 3))
    bottom = points[:, 2].min() - rng.uniform(0.0, 0.03)
    solid = fit_solid(points, bottom)
    field = ObjectField([SceneObject("thing", solid)])
    low = points.copy()
    low[:, 2] = bottom
    foot = low[[points[:, 2].argmin()]]
    inside = field.clearances(Spheres.at(points)).distance
    assert (inside < 1e-9).all()
    assert field.clearances(Spheres.at(foot)).distance[0] < 1e-9
    assert solid.top == pytest.approx(points[:, 2].max() + MARGIN)
