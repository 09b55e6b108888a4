"""Free places on top of objects, in worlds worked by hand."""

import dataclasses as dc

import numpy as np
import pytest
from carried import HALF_HEIGHT, RADIUS, around_can, can_at
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.task.free_places import (
    APART,
    MOST,
    Surroundings,
    free_places,
    level_top,
)

CAN = can_at(RigidTransform([2.0, 2.0, 2.0]))
STOPPING = 0.02
BULGE = around_can().radius[0] - RADIUS
EMPTY = Surroundings(ObjectField(()), STOPPING)


def tray(half=(0.2, 0.1, 0.02), rpy=(0, 0, 0), p_W=(0.5, 0.0, 0.3)):
    X_WO = RigidTransform(RollPitchYaw(rpy), p_W)
    return SceneObject("tray", Box(X_WO, np.array(half, float)))


def places(support, around=EMPTY, near=None):
    found = free_places(CAN, around_can(), support, around, near)
    return np.array([X_WO.translation() for X_WO in found])


def among(*others):
    return dc.replace(EMPTY, field=ObjectField(others))


def test_the_first_place_is_the_middle_of_the_top():
    found = places(tray())
    assert found[0] == pytest.approx([0.5, 0.0, 0.32 + HALF_HEIGHT])
    # The others are next to it, but not so near that a robot that misses one
    # misses all, and all are at one height.
    assert len(found) == MOST and np.ptp(found[:, 2]) < 1e-9
    away = np.linalg.norm(found[:, None] - found, axis=2)
    np.fill_diagonal(away, np.inf)
    assert (away.min(axis=1) >= APART - 1e-9).all()
    assert away.min(axis=1).max() < APART + 0.03


def test_the_whole_footprint_is_on_the_top():
    corner = places(tray(), near=np.array([9.0, 9.0, 0.0]))[0]
    room = np.array([0.7, 0.1]) - corner[:2]
    assert (room >= RADIUS - 1e-9).all() and (room < RADIUS + 0.02).all()
    turned = places(tray(rpy=(0, 0, np.pi / 2)), near=np.array([9.0, 9.0, 0]))
    room = np.array([0.6, 0.2]) - turned[0][:2]
    assert (room >= RADIUS - 1e-6).all() and (room < RADIUS + 0.02).all()


def test_another_object_keeps_it_away():
    other = SceneObject(
        "cup", Cylinder(RigidTransform([0.5, 0.0, 0.38]), 0.03, 0.06)
    )
    found = places(tray(), among(other))
    gap = np.linalg.norm(found[:, :2] - [0.5, 0.0], axis=1) - 2 * RADIUS
    assert gap.min() > STOPPING + BULGE - 1e-9
    assert gap.min() < STOPPING + BULGE + 0.02


def test_a_full_top_is_refused():
    other = SceneObject(
        "box", Box(RigidTransform([0.5, 0.0, 0.4]), np.array([0.1, 0.1, 0.08]))
    )
    with pytest.raises(RemoSplatError, match="tray has no free place"):
        places(tray(half=(0.14, 0.1, 0.02)), among(other))


def test_a_ceiling_counts():
    lid = SceneObject(
        "lid", Box(RigidTransform([0.5, 0.0, 0.46]), np.array([1.0, 1.0, 0.01]))
    )
    with pytest.raises(RemoSplatError, match="has no free place"):
        places(tray(), among(lid))


@pytest.mark.parametrize(
    ("support", "message"),
    [
        (tray(rpy=(0.05, 0, 0)), "the top of the tray is tilted"),
        (tray(half=(0.2, 0.025, 0.02)), "too small for the can"),
    ],
)
def test_a_top_that_holds_nothing_is_refused(support, message):
    with pytest.raises(RemoSplatError, match=message):
        places(support)


def test_a_top_out_of_reach_is_refused():
    near = dc.replace(EMPTY, p_WA=np.zeros(3), reach=0.6)
    found = places(tray(), near)
    assert np.linalg.norm(found, axis=1).max() <= 0.6
    far = dc.replace(near, reach=0.4)
    message = r"too far: its nearest free place is 0\.\d\d m from the shoulder"
    with pytest.raises(RemoSplatError, match=message):
        places(tray(), far)


def test_tops_of_cylinders_and_hulls_are_level():
    stool = Cylinder(RigidTransform([0, 0, 0.2]), 0.15, 0.2)
    top, height = level_top(SceneObject("stool", stool))
    assert height == pytest.approx(0.4)
    assert np.linalg.norm(top, axis=1).max() == pytest.approx(0.15, abs=0.005)
    corners = np.array([[x, y, 0.0] for x in (-1, 1) for y in (-1, 1)])
    roof = np.array([[0.1, 0, 1], [-0.1, 0, 1]])
    hull = ConvexHull(RigidTransform(), np.concatenate([corners, roof]))
    with pytest.raises(RemoSplatError, match="is tilted"):
        level_top(SceneObject("roof", hull))
