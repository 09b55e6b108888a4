"""Rays that meet surfaces, worked by hand, and targets before them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.cockpit.surface_point import (
    SurfacePoint,
    find_surface,
    target_before,
)
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

CUBE = PrimitiveScene(
    boxes=(Box(RigidTransform([2.0, 0.0, 0.0]), np.full(3, 0.5)),)
)
FIELD = SignedDistanceField(CUBE)
EYE = np.zeros(3)


def test_a_ray_meets_the_face_in_its_way():
    found = find_surface(FIELD, EYE, np.array([3.0, 0.3, 0.0]))
    assert found is not None
    np.testing.assert_allclose(found.p_W, [1.5, 0.15, 0.0], atol=2e-3)
    np.testing.assert_allclose(found.normal_W, [-1, 0, 0], atol=1e-6)


@pytest.mark.parametrize(
    "direction",
    [[-1.0, 0, 0], [1.0, 0.5, 0], [0.0, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]],
)
def test_a_ray_into_the_void_meets_nothing(direction):
    assert find_surface(FIELD, EYE, np.array(direction)) is None


def test_unseen_space_is_nothing_to_click_at():
    unseen = np.ones((4, 4, 4), bool)
    unseen[0, 0, 0] = False
    field = CompositeDistanceField(
        [FIELD, UnknownSpaceField(unseen, np.full(3, -5.0), 0.1)]
    )
    surfaces = field.surfaces
    assert surfaces is not None
    found = find_surface(surfaces, EYE, np.array([1.0, 0.0, 0.0]))
    assert found is not None and abs(found.p_W[0] - 1.5) < 2e-3
    assert field.parts[1].surfaces is None


ANGLE = st.floats(-3.1, 3.1)


@given(ANGLE, st.floats(-1.5, 1.5), ANGLE, ANGLE, st.floats(-1.5, 1.5))
def test_a_target_looks_at_the_surface_along_its_normal(a, b, c, yaw, pitch):
    X_WE = RigidTransform(RollPitchYaw([a, b, c]), [0, 0, 1]).GetAsMatrix4()
    normal = RollPitchYaw([0, pitch, yaw]).ToRotationMatrix().matrix()[:, 0]
    surface = SurfacePoint(np.array([0.4, -0.2, 0.6]), normal)
    X_WT = target_before(surface, X_WE, 0.1)
    R = X_WT[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(R) > 0
    np.testing.assert_allclose(R[:, 2], -normal, atol=1e-9)
    np.testing.assert_allclose(X_WT[:3, 3], surface.p_W + 0.1 * normal)


def test_a_target_turns_no_more_than_it_must():
    """Above a table a hand that points down already is not turned at all."""
    X_WE = RigidTransform(
        RollPitchYaw([np.pi, 0, 0.3]), [0, 0, 1]
    ).GetAsMatrix4()
    top = SurfacePoint(np.array([0.5, 0, 0.7]), np.array([0.0, 0, 1]))
    X_WT = target_before(top, X_WE, 0.1)
    np.testing.assert_allclose(X_WT[:3, :3], X_WE[:3, :3], atol=1e-9)
