"""A door turns about its hinge, smoothly, within the bounds told."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.scene.moving.door import DoorAngle, SwingingDoor

DOOR = SwingingDoor(
    hinge=[1.0, 2.0, 0.0],
    width=0.8,
    height=2.0,
    angles=[DoorAngle(1.0, 90.0), DoorAngle(2.5, 0.0), DoorAngle(5.0, 45.0)],
)


def at(time: float):
    (door,) = DOOR.make(Path()).movers(time)
    return door


@pytest.mark.parametrize("time", [0.0, 1.7, 3.1, 9.0])
def test_its_hinge_stands_still(time):
    door = at(time)
    edge = [-0.4, 0.0, -1.0]
    np.testing.assert_allclose(door.X_WM @ edge, [1.0, 2.0, 0.0], atol=1e-12)
    v_W = door.v_WM + np.cross(door.w_WM, door.X_WM.rotation() @ edge)
    np.testing.assert_allclose(v_W, 0.0, atol=1e-12)


def test_it_is_open_as_far_as_it_says():
    np.testing.assert_allclose(at(2.5).X_WM @ [0.4, 0, 0], [1.8, 2.0, 1.0])
    np.testing.assert_allclose(at(0.0).X_WM @ [0.4, 0, 0], [1.0, 2.8, 1.0])
    assert not at(0.9).w_WM.any() and not at(5.1).w_WM.any()


def test_its_edge_keeps_the_bounds():
    h, corner = 1e-3, np.array([0.4, 0.02, 1.0])
    p_W = np.array([at(t).X_WM @ corner for t in np.arange(0.9, 5.1, h)])
    v_W = np.diff(p_W, axis=0) / h
    a_W = np.diff(v_W, axis=0) / h
    assert np.linalg.norm(v_W, axis=1).max() < at(0.0).max_speed
    # At the ends, where it starts, a difference sees half of the jump.
    assert np.linalg.norm(a_W, axis=1).max() < at(0.0).max_acceleration


def test_time_goes_on():
    with pytest.raises(FieldError, match=r"angles\[1\]\.time"):
        SwingingDoor(angles=[DoorAngle(1.0), DoorAngle(1.0)])


def test_one_that_stays_does_not_move():
    (door,) = SwingingDoor(angles=[DoorAngle(0.0, 30.0)]).make(Path()).movers(2)
    assert (door.max_speed, door.max_acceleration) == (0.0, 0.0)
