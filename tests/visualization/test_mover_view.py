"""Movers are on the page at their places, and go when they are gone."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.geometry import Box, Capsule, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.scene.mover_shape import shape_of
from remosplat_drake.visualization.mover_view import (
    CAMERAS,
    MOVERS,
    MoverView,
    pyramid,
    room_of,
)

BALL = Mover.sphere("ball", [1, 2, 3], 0.1, v_WM=[0.5, 0, 0])
ARM = Mover.capsule("arm", RigidTransform([0, 0, 1]), 0.2, 0.05)
DOOR = Mover.box("door", RigidTransform(), [0.4, 0.02, 1.0])


@pytest.fixture
def show(page):
    dut = MoverView(page=page)
    context = dut.CreateDefaultContext()
    port = dut.GetInputPort("movers")

    def _show(*movers: Mover):
        port.FixValue(context, Value[object](Movers(0.0, movers)))
        dut.ForcedPublish(context)

    return _show


def test_movers_come_and_go(show, page):
    show(BALL, ARM)
    for name in ("0_ball", "1_arm"):
        for part in ("body", "ghost", "room"):
            assert page.meshcat.HasPath(f"{MOVERS}/{name}/{part}")
    show(ARM)
    assert not page.meshcat.HasPath(f"{MOVERS}/0_ball")
    assert not page.meshcat.HasPath(f"{MOVERS}/1_arm")
    assert page.meshcat.HasPath(f"{MOVERS}/0_arm")


def test_they_are_where_they_are(show, page, pose_of):
    show(BALL)
    before = pose_of(page.meshcat, f"{MOVERS}/0_ball/body")
    show(Mover.sphere("ball", [1, 2, 4], 0.1))
    after = pose_of(page.meshcat, f"{MOVERS}/0_ball/body")
    np.testing.assert_allclose(after[:3, 3] - before[:3, 3], [0, 0, 1])


@pytest.mark.parametrize(
    ("mover", "shape"), [(BALL, Sphere), (ARM, Capsule), (DOOR, Box)]
)
def test_they_look_like_what_they_are(mover, shape):
    assert isinstance(shape_of(mover), shape)


def test_the_room_is_what_it_may_need_by_then():
    still = Mover.sphere("it", [0, 0, 0], 0.1, max_acceleration=2.0)
    assert room_of(still, 0.3) == pytest.approx(0.1 + 0.09)
    slow = Mover.sphere("it", [0, 0, 0], 0.1, max_speed=0.1)
    assert room_of(slow, 0.3) == pytest.approx(0.1 + 0.03)
    long = np.linalg.norm([0.4, 0.02, 1.0])
    assert room_of(DOOR, 0.0) == pytest.approx(long)


def test_a_shape_that_changes_is_drawn_anew(show, page):
    """What cameras see of a thing is never twice the same."""
    show(BALL)
    path = f"{MOVERS}/0_ball/body"
    before = page.meshcat._GetPackedObject(path)
    show(Mover.sphere("ball", [1, 2, 3], 0.101))
    assert page.meshcat._GetPackedObject(path) == before
    show(Mover.sphere("ball", [1, 2, 3], 0.2))
    assert page.meshcat._GetPackedObject(path) != before


def test_cameras_are_drawn_as_they_look(page):
    X_WC = RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0, 0, 2])
    camera = MoverCamera("top", X_WC, [-1, -0.5], [1, 0.5], 0.2, 4.0, 0.0)
    start, end = pyramid(camera, 0.5)
    assert start[:, :4] == pytest.approx(np.array([[0, 0, 2]] * 4).T)
    assert end[2] == pytest.approx(1.5)
    assert np.abs(end[0]).max() == pytest.approx(0.5)
    assert np.abs(end[1]).max() == pytest.approx(0.25)
    dut = MoverView(page=page)
    context = dut.CreateDefaultContext()
    movers = Movers(0.0, (), (camera,))
    dut.GetInputPort("movers").FixValue(context, Value[object](movers))
    dut.ForcedPublish(context)
    assert page.meshcat.HasPath(f"{CAMERAS}/top")
