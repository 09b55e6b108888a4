"""Toy clouds whose nearest points are known, and brute force beside them."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.robot.sphere_model import Spheres


def test_the_nearest_point_its_distance_and_direction():
    dut = PointDistanceField(np.array([[1.0, 0, 0], [0, 3, 0]]))
    answer = dut.clearances(Spheres.at([[0, 0, 0], [0, 2.5, 0]], 0.2))
    np.testing.assert_array_equal(answer.sphere, [0, 1])
    np.testing.assert_allclose(answer.distance, [0.8, 0.3], atol=1e-15)
    np.testing.assert_allclose(answer.direction_W, [[1, 0, 0], [0, 1, 0]])
    np.testing.assert_allclose(answer.p_WC, [[1, 0, 0], [0, 3, 0]])
    assert answer.revision == dut.revision


def test_rows_at_the_queried_distance_or_beyond_are_left_out():
    dut = PointDistanceField(np.array([[1.0, 0, 0]]))
    spheres = Spheres.at([[0, 0, 0], [0.5, 0, 0]], [0.5, 0.0])
    assert len(dut.clearances(spheres, 0.5)) == 0
    assert len(dut.clearances(spheres, 0.501)) == 2


def test_each_sphere_ignores_the_points_below_its_own_height():
    dut = PointDistanceField(np.array([[0, 0, 0.02], [0, 0, 0.5]]))
    spheres = Spheres.at([[0, 0, 0.1], [0, 0, 0.1], [0, 0, 0.1]])
    spheres.ignore_below[:] = [-np.inf, 0.03, 0.6]
    answer = dut.clearances(spheres)
    np.testing.assert_array_equal(answer.sphere, [0, 1])
    np.testing.assert_allclose(answer.distance, [0.08, 0.4])


def test_a_centre_on_a_point_gets_a_fixed_direction():
    answer = PointDistanceField(np.ones((1, 3))).clearances(
        Spheres.at([[1, 1, 1]], 0.1)
    )
    np.testing.assert_allclose(answer.distance, [-0.1])
    np.testing.assert_array_equal(answer.direction_W, [[0, 0, -1]])


def test_an_empty_cloud_is_far_from_everything():
    dut = PointDistanceField(np.zeros((0, 3)))
    assert len(dut.clearances(Spheres.at([[0, 0, 0]]))) == 0


def test_equal_clouds_have_equal_revisions():
    points = np.arange(6.0).reshape(2, 3)
    dut = PointDistanceField(points)
    assert dut.revision == PointDistanceField(points).revision
    assert dut.revision != PointDistanceField(points + 1e-9).revision
    assert copy.deepcopy(dut) is dut


@pytest.mark.parametrize(
    "points", [np.zeros(3), np.zeros((2, 2)), np.full((1, 3), np.nan)]
)
def test_refuses_what_is_no_cloud(points):
    with pytest.raises(RemoSplatError, match="point"):
        PointDistanceField(points)


def test_refuses_an_undefined_sphere():
    dut = PointDistanceField(np.zeros((1, 3)))
    with pytest.raises(ValueError, match="not finite"):
        dut.clearances(Spheres.at([[np.nan, 0, 0]]))


@settings(max_examples=20)
@given(seed=st.integers(0, 2**16), max_distance=st.floats(-0.1, 1.0))
def test_equals_trying_every_point(seed, max_distance):
    rng = np.random.default_rng(seed)
    points, centers = rng.uniform(0, 1, (50, 3)), rng.uniform(0, 1, (9, 3))
    spheres = Spheres.at(centers, rng.uniform(0, 0.2, 9))
    spheres.ignore_below[:] = rng.choice([-np.inf, 0.3, 0.8], 9)
    distance = np.linalg.norm(centers[:, None] - points, axis=2)
    distance[points[:, 2] < spheres.ignore_below[:, None]] = np.inf
    expected = distance.min(axis=1) - spheres.radius
    expected[expected >= max_distance] = np.inf
    answer = PointDistanceField(points).clearances(spheres, max_distance)
    np.testing.assert_allclose(answer.per_sphere(9), expected, atol=1e-12)
