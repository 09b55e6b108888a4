"""Random states, and distance errors that are known beforehand."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from apps.studies.robot_states import (
    INFLUENCE,
    distance_errors,
    free_states,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene


def wall(x: float) -> SignedDistanceField:
    """Everything beyond a plane."""
    box = Box(RigidTransform([x + 5, 0, 0]), np.array([5.0, 9.0, 9.0]))
    return SignedDistanceField(PrimitiveScene(boxes=(box,)))


def test_states_are_free_near_the_scene_and_repeatable(frankie):
    truth = wall(1.0)
    states = free_states(frankie, truth, 20, seed=5)
    np.testing.assert_array_equal(states, free_states(frankie, truth, 20, 5))
    assert (states >= frankie.position_lower).all()
    assert (states <= frankie.position_upper).all()
    for q in states:
        clearance = truth.clearances(frankie.spheres_at(q)).minimum()
        assert 0 < clearance < INFLUENCE


def test_a_wall_that_is_misplaced_is_an_error_of_that_size(frankie):
    truth = wall(1.0)
    states = free_states(frankie, truth, 5)
    nearer, spheres = distance_errors(frankie, wall(0.99), truth, states)
    np.testing.assert_allclose(nearer, -0.01)
    assert len(nearer) == len(spheres)
    farther, _ = distance_errors(frankie, wall(1.02), truth, states)
    assert farther.max() == pytest.approx(0.02)
    # Beyond the influence distance there is no query.
    distance = truth.clearances(spheres).per_sphere(len(spheres))
    expected = np.minimum(distance + 0.02, INFLUENCE) - distance
    np.testing.assert_allclose(farther, expected, atol=1e-12)


def test_an_overlooked_scene_counts_as_far_away(frankie):
    truth = wall(1.0)
    states = free_states(frankie, truth, 5)
    error, spheres = distance_errors(frankie, wall(9.0), truth, states)
    distance = truth.clearances(spheres).per_sphere(len(spheres))
    np.testing.assert_allclose(error, INFLUENCE - distance)
