"""Masks movers (moving objects) in the frames from which maps are built."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import back_project
from remosplat_drake.capture.frames import Frame
from remosplat_drake.robot.planar_pose import matrix
from remosplat_drake.scene.kernels.mover_reach import reach
from remosplat_drake.scene.mover import Movers

_MARGIN = 0.05
"""Measured points within this distance of a mover belong to it [m]."""

_W_IS_O = np.zeros(3)


def hide_movers(
    frame: Frame, movers: Movers, X_WO: np.ndarray = _W_IS_O
) -> Frame:
    """Masks the pixels of a frame that may show a mover.

    Otherwise the mover would stay in the map as an obstacle until a later frame
    shows free space there.

    Args:
        frame: The frame, with colours, depths and hidden pixels of one size, as
            `CameraMount.frame` makes it. If it has no time, the movers' time
            stamp is assumed.
        movers: The movers in W, with velocities and bounds.
        X_WO: Pose of the odometry's frame O in W (x, y, yaw), shape (3,) [m,
            rad]. The camera pose of `frame` is expressed in O.

    Returns:
        A frame in which the pixels that may show a mover have no depth and are
        hidden; the same frame if there are no such pixels.
    """
    if not len(movers):
        return frame
    time = movers.stamp if frame.time is None else frame.time
    arrays = movers.at(time)
    known = frame.depth > 0
    p_WS = back_project(frame.K, frame.depth, matrix(X_WO) @ frame.X_WC)
    p_WS = p_WS[known]
    near_any = np.zeros(len(p_WS), bool)
    for i, mover in enumerate(movers.predicted(time)):
        p_WM, R_WM = mover.X_WM.translation(), mover.X_WM.rotation().matrix()
        p_MS = (p_WS - p_WM) @ R_WM
        outside = np.maximum(np.abs(p_MS) - mover.half_extents, 0.0)
        near = mover.radius + reach(arrays, i, 0.0) + _MARGIN
        near_any |= np.einsum("ij,ij->i", outside, outside) <= near * near
    if not near_any.any():
        return frame
    shown = np.zeros(frame.depth.shape, bool)
    shown[known] = near_any
    depth = np.where(shown, np.float32(0), frame.depth)
    hidden = shown if frame.hidden is None else frame.hidden | shown
    return dc.replace(frame, depth=depth, hidden=hidden)
