"""Frames in which something moves."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.hide_movers import hide_movers
from remosplat_drake.robot.planar_pose import matrix
from remosplat_drake.scene.mover import Mover, Movers

K = np.array([[40.0, 0, 20.5], [0, 40, 15.5], [0, 0, 1]])
X_WC = RigidTransform([1.0, 2.0, 3.0]).GetAsMatrix4()


def wall_frame(time: float | None = 5.0) -> Frame:
    """A wall 2 m ahead, before which a pixel shows something 1 m away."""
    depth = np.full((31, 41), 2.0, np.float32)
    depth[15, 20] = 1.0
    depth[0] = 0.0
    rgb = np.zeros((31, 41, 3), np.uint8)
    return Frame("wall", K, X_WC, rgb, depth, time=time)


def sphere(z: float, **rest) -> Mover:
    return Mover.sphere("ball", [1.0, 2.0, 3.0 + z], 0.1, **rest)


def test_what_moves_is_hidden_and_nothing_beside_it():
    frame = hide_movers(wall_frame(), Movers(5.0, [sphere(1.1)]))
    assert frame.hidden is not None
    assert np.argwhere(frame.hidden).tolist() == [[15, 20]]
    assert frame.depth[15, 20] == 0.0
    assert (frame.depth == 2.0).sum() == 31 * 41 - 41 - 1
    # Of the wall as much is hidden as is within a ball and the margin.
    touching = hide_movers(wall_frame(), Movers(5.0, [sphere(2.0)]))
    assert touching.hidden is not None
    assert touching.hidden.sum() == pytest.approx(np.pi * 0.15**2 * 400, abs=6)


def test_it_is_hidden_where_it_was_when_the_frame_was_taken():
    ball = sphere(2.1, v_WM=np.array([0, 0, -1.0]), max_acceleration=0.0)
    assert hide_movers(wall_frame(4.0), Movers(4.0, [ball])).depth[15, 20]
    assert not hide_movers(wall_frame(5.0), Movers(4.0, [ball])).depth[15, 20]


def test_it_is_hidden_wherever_it_can_have_been_by_then():
    bounds = {"max_acceleration": 2.0, "max_speed": 1.0}
    movers = Movers(4.0, [sphere(1.7, **bounds)])
    # 0.6 m from its surface, of which 5 cm are the noise of the camera.
    assert hide_movers(wall_frame(4.7), movers).depth[15, 20]
    assert not hide_movers(wall_frame(4.8), movers).depth[15, 20]


def test_it_is_hidden_where_a_drifting_base_sees_it():
    """The base is 1 m farther on than its odometry says, and turned about."""
    X_WO = np.array([1.0, 0.3, np.pi / 2])
    p_OM = np.array([1.0, 2.0, 4.1])
    p_WM = (matrix(X_WO) @ [*p_OM, 1.0])[:3]
    movers = Movers(5.0, [Mover.sphere("ball", p_WM, 0.1)])
    frame = hide_movers(wall_frame(), movers, X_WO)
    assert frame.hidden is not None
    assert np.argwhere(frame.hidden).tolist() == [[15, 20]]
    np.testing.assert_array_equal(frame.X_WC, X_WC)
    assert hide_movers(wall_frame(), movers).hidden is None


def test_what_was_hidden_remains_so():
    frame = wall_frame()
    robot = np.zeros(frame.depth.shape, bool)
    robot[3, 4] = True
    frame = Frame("wall", K, X_WC, frame.rgb, frame.depth, robot, time=None)
    hidden = hide_movers(frame, Movers(5.0, [sphere(1.1)])).hidden
    assert hidden is not None
    assert np.argwhere(hidden).tolist() == [[3, 4], [15, 20]]


@pytest.mark.parametrize("movers", [[], [sphere(-1.0)], [sphere(1.5)]])
def test_a_frame_without_movers_is_as_it_was(movers):
    frame = wall_frame()
    assert hide_movers(frame, Movers(5.0, movers)) is frame
