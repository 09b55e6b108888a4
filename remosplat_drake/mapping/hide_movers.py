"""Keeps what moves out of the frames that maps are made of."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import back_project
from remosplat_drake.capture.frames import Frame
from remosplat_drake.scene.mover import Movers

_MARGIN = 0.05
"""How far from a mover a measured point may still be its own [m]."""


def hide_movers(frame: Frame, movers: Movers) -> Frame:
    """Hides the pixels of a frame that may show something that moves.

    A map that had taken them for things that stand would keep a ghost until a
    later frame looks through it.

    Args:
        frame: The frame; one without a time was taken at the movers' stamp.
        movers: What moves, with the velocities that it has.

    Returns:
        A frame without depth where a point lies on or near a mover, and with
        these pixels among the hidden ones; the frame itself where none does.
    """
    if not len(movers):
        return frame
    time = movers.stamp if frame.time is None else frame.time
    late = abs(time - movers.stamp)
    p_WS = back_project(frame.K, frame.depth, frame.X_WC)
    shown = np.zeros(frame.depth.shape, bool)
    for mover in movers.predicted(time):
        p_WM, R_WM = mover.X_WM.translation(), mover.X_WM.rotation().matrix()
        p_MS = (p_WS - p_WM) @ R_WM
        outside = np.maximum(np.abs(p_MS) - mover.half_extents, 0.0)
        near = mover.radius + mover.position_error + _MARGIN
        near += mover.velocity_error * late
        # Where there is no depth the distance is not a number: not near.
        shown |= np.linalg.norm(outside, axis=-1) <= near
    if not shown.any():
        return frame
    depth = np.where(shown, np.float32(0), frame.depth)
    hidden = shown if frame.hidden is None else frame.hidden | shown
    return dc.replace(frame, depth=depth, hidden=hidden)
