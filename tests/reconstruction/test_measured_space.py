"""Space measured by depth images, in a room worked out by hand."""

import numpy as np
import pytest

from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.coverage import make_coverage
from remosplat_drake.reconstruction.measured_space import (
    free_points,
    measured_points,
    scatter,
    thinned,
    times_looked_through,
    voxel_means,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN

EVERYWHERE = np.full(3, -9.0), np.full(3, 9.0)


@pytest.fixture
def wall() -> Capture:
    """Two cameras at the origin that see the plane z = 2, 2 m square."""
    n, size = 2, 40
    K = np.array([[size, 0, size / 2], [0, size, size / 2], [0, 0, 1.0]])
    return Capture(
        K=np.tile(K, (n, 1, 1)),
        X_WC=np.tile(np.eye(4), (n, 1, 1)),
        rgb=np.zeros((n, size, size, 3), np.uint8),
        depth=np.full((n, size, size), 2, np.float32),
    )


def test_views_look_through_what_is_before_the_wall(wall):
    points = [[0, 0, 1], [0, 0, 1.96], [0, 0, 1.98], [0, 0, 3], [3, 0, 1]]
    points += [[0, 0, -1]]
    count = times_looked_through(wall, np.array(points), margin=0.03)
    np.testing.assert_array_equal(count, [2, 2, 0, 0, 0, 0])


def test_beside_unknown_depth_nothing_is_looked_through(wall):
    wall.depth[0, 20, 21] = 0
    center = np.array([[0.01, 0.01, 1.0]])
    assert times_looked_through(wall, center) == [1]


def test_a_view_says_nothing_of_what_is_finer_than_its_pixels(wall):
    """At a depth of 1 m these are 25 mm apart."""
    point = np.array([[0.0, 0, 1], [0, 0, 1]])
    count = times_looked_through(wall, point, pitch=np.array([0.024, 0.026]))
    np.testing.assert_array_equal(count, [0, 2])


def test_a_margin_along_the_normal_is_longer_at_a_slant(wall):
    """7 cm before the wall, on surfaces at 90 and at 24 degrees to the ray.

    Along the depth 30 mm suffice; for the slanted one it takes 30 / 0.4 = 75.
    """
    points = np.tile([0.0, 0, 1.926], (2, 1))
    normals = np.array([[0, 0, 1.0], slanted(0.4)])
    count = times_looked_through(wall, points, 0.03, normal_W=normals)
    np.testing.assert_array_equal(count, [2, 0])
    nearer = points - [0, 0, 0.002]
    count = times_looked_through(wall, nearer, 0.03, normal_W=normals)
    np.testing.assert_array_equal(count, [2, 2])


def test_a_view_along_a_surface_does_not_contradict_it(wall):
    """A leaf 1 m before the wall, at 72 and at 73.5 degrees of incidence."""
    points = np.tile([0.0, 0, 1.0], (2, 1))
    normals = np.array([slanted(0.31), slanted(-0.28)])
    count = times_looked_through(wall, points, 0.03, normal_W=normals)
    np.testing.assert_array_equal(count, [2, 0])


def slanted(cosine: float) -> list[float]:
    """A unit normal at an angle with this cosine to the axis z."""
    return [np.sqrt(1 - cosine**2), 0, cosine]


def test_measured_points_are_on_the_wall(wall):
    points = measured_points(wall, *EVERYWHERE)
    assert len(points) == 1600
    np.testing.assert_allclose(points[:, 2], 2)
    right = measured_points(wall, np.zeros(3), EVERYWHERE[1])
    assert len(right) == 400


def test_a_point_that_others_look_through_is_no_surface(wall):
    wall = wall.select([0, 1, 0])
    wall.depth[2, 20, 20] = 1.5
    assert measured_points(wall, *EVERYWHERE)[:, 2].min() == pytest.approx(2)


def test_voxels_hold_means():
    points = np.array([[0, 0, 0], [0.2, 0, 0], [1.1, 0, 0]])
    np.testing.assert_allclose(
        voxel_means(points, 1.0), [[0.1, 0, 0], [1.1, 0, 0]]
    )
    assert len(voxel_means(np.zeros((0, 3)), 1.0)) == 0


def test_a_noisy_layer_becomes_a_plane():
    rng = np.random.default_rng(0)
    layer = rng.uniform(-0.2, 0.2, (4000, 3))
    layer[:, 2] = rng.normal(0, 0.005, 4000)
    assert scatter(layer) == pytest.approx(0.005, rel=0.1)
    plane = thinned(layer)
    inner = (np.abs(plane[:, :2]) < 0.15).all(axis=1)
    assert np.abs(plane[inner, 2]).max() < 0.005
    assert plane[inner, 2].std() < 0.0015


def test_free_points_are_before_surfaces(scene, scene_capture):
    lower, upper = np.array([0.5, -0.5, 0.1]), np.array([1.5, 0.5, 1.0])
    points = free_points(scene_capture, 1000, lower, upper)
    assert len(points) == 1000
    assert ((points >= lower) & (points <= upper)).all()
    distance = SignedDistanceField(scene).clearances(Spheres.at(points))
    assert distance.distance.min() > -1e-5


def test_coverage_of_the_wall(wall):
    """Free before the wall, nothing known behind it."""
    surface = measured_points(wall, *EVERYWHERE)
    lower, upper = np.array([-0.5, -0.5, 1.1]), np.array([0.5, 0.5, 2.3])
    coverage = make_coverage(wall, surface, lower, upper, voxel=0.4)
    assert coverage.state.shape == (3, 3, 3)
    np.testing.assert_array_equal(coverage.state[:, :, 0], FREE)
    np.testing.assert_array_equal(coverage.state[:, :, 2], SURFACE)
    behind = make_coverage(wall, surface, np.array([0, 0, 2.5]), np.full(3, 3))
    assert behind.fraction(UNSEEN) == 1
    np.testing.assert_allclose(behind.upper, [3, 3, 3])
