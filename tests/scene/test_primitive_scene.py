"""Primitive scenes: heights, hashes, sizes."""

import copy

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene


def _scene(height=0.5):
    return PrimitiveScene(
        boxes=(Box(RigidTransform([1, 0, height]), np.array([0.5, 2, 0.03])),),
        cylinders=(Cylinder(RigidTransform([1, 0, 0.5]), 0.05, 0.3),),
    )


def test_copy_is_the_scene_itself():
    scene = _scene()
    assert copy.deepcopy(scene) is scene


def test_hash_follows_the_geometry_only():
    assert _scene().content_hash == _scene().content_hash
    assert _scene().content_hash != _scene(0.51).content_hash
    assert _scene().content_hash != _scene().with_floor().content_hash


def test_top_of_a_tilted_box_is_its_highest_corner():
    X_WP = RigidTransform(RollPitchYaw(0.3, -0.7, 1.1), [0.1, 0.2, 0.3])
    h = np.array([0.2, 0.4, 0.6])
    signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1)
    corners_W = X_WP.multiply(signs * h[:, None])
    assert Box(X_WP, h).top == pytest.approx(corners_W[2].max())


def test_top_of_a_tilted_cylinder_is_on_its_rim():
    X_WP = RigidTransform(RollPitchYaw(0.4, 0.9, 0), [0, 0, 1])
    angle = np.linspace(0, 2 * np.pi, 20001)
    rim = np.stack(
        [0.1 * np.cos(angle), 0.1 * np.sin(angle), np.full_like(angle, 0.3)]
    )
    top = max(X_WP.multiply(rim)[2].max(), X_WP.multiply(-rim)[2].max())
    assert Cylinder(X_WP, 0.1, 0.3).top == pytest.approx(top, abs=1e-8)


def test_floor_ends_at_zero():
    floor = _scene().with_floor().boxes[-1]
    assert floor.top == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("extents", [[1, 1], [1, 1, 0], [1, 1, np.nan]])
def test_rejects_sizes_that_are_not_positive(extents):
    with pytest.raises(RemoSplatError, match="half_extents"):
        Box(RigidTransform(), np.array(extents))
