"""Chooses a map's frame: that of the capture, or one with the floor at z = 0.

The frame of a handheld capture is often that of its first image, whose z axis
is not vertical. The direction of gravity is computed from the floor, or the
capture's file format defines it. If neither is possible, the direction is
unknown, and the capture's frame is kept.
"""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.floor import FloorConfig, find_floor

AUTO, FLOOR, CAPTURE, NONE = UPS = ("auto", "floor", "capture", "none")
"""Names of the ways to find the upward direction, in this order: from the
floor, or from the file format if no floor is found; only from the floor; only
from the format; not at all.
"""

_LEVEL = np.deg2rad(3.0)
"""A frame counts as upright if its tilt is at most this [rad]: the usual error
of a floor's normal due to inexact poses.
"""

_ON_FLOOR = 0.05
"""A floor is already aligned if its distance from z = 0 is at most this [m]."""

_FLOOR_TILT = 0.15
"""Largest angle between a floor's normal and the known upward direction [rad].
"""

_LOW = 0.7
"""A floor may be a table if the cameras' height above it is less than this [m].
"""


@dc.dataclass(frozen=True, eq=False)
class Placement:
    """The pose of a map's frame.

    Attributes:
        X_FW: Pose of the capture's frame W in the map's frame F.
        words: Sentence that describes how the frame was found.
        has_floor: Whether F is known to have z up and the floor at z = 0.
    """

    X_FW: RigidTransform
    words: str
    has_floor: bool

    @property
    def moves(self) -> bool:
        """Whether F is another frame than W."""
        return not self.X_FW.IsExactlyIdentity()

    def placed(self, capture: Capture) -> Capture:
        """Returns the capture with camera poses expressed in F."""
        if not self.moves:
            return capture
        return capture.expressed_in(self.X_FW.GetAsMatrix4())


def place(capture: Capture, up: str = AUTO) -> Placement:
    """Finds the frame of a capture's map.

    Args:
        capture: Posed RGB-D images.
        up: One of `UPS`.

    Raises:
        RemoSplatError: `up` requires a floor, and no plane meets the
            thresholds.
    """
    if up == NONE:
        return Placement(RigidTransform(), "in the capture's frame", False)
    if up == FLOOR:
        return _on_floor(capture)
    if up == CAPTURE:
        return _as_captured(capture)
    try:
        placement = _on_floor(capture)
    except RemoSplatError as error:
        if capture.up_W is not None:
            placement = _as_captured(capture)
            return dc.replace(
                placement,
                words=f"{error}; {placement.words}",
                has_floor=False,
            )
        return Placement(RigidTransform(), str(error), False)
    R_FW, p_FW = placement.X_FW.rotation(), placement.X_FW.translation()
    tilt = np.arccos(np.clip(R_FW.matrix()[2, 2], -1, 1))
    if tilt > _LEVEL or abs(p_FW[2]) > _ON_FLOOR:
        return placement
    words = (
        f"{placement.words}; the capture's frame has z = 0 there and is kept"
    )
    return Placement(RigidTransform(), words, True)


def _on_floor(capture: Capture) -> Placement:
    config = FloorConfig()
    if capture.up_W is not None:
        config.max_tilt = _FLOOR_TILT
    floor = find_floor(capture, config)
    words = (
        f"the floor was found: {floor.area:.1f} m², flat to "
        f"{1e3 * floor.rms:.1f} mm, cameras {floor.camera_height:.2f} m above"
    )
    if floor.camera_height < _LOW:
        words += "; if that is a table, use --up none"
    return Placement(floor.X_FW, words, True)


def _as_captured(capture: Capture) -> Placement:
    """Returns the capture's own frame, rotated so that z is up."""
    up_W = np.array([0, 0, 1.0] if capture.up_W is None else capture.up_W)
    if up_W[2] > np.cos(_LEVEL):
        words = "up is the capture's z axis; the floor is assumed at z = 0"
        return Placement(RigidTransform(), words, True)
    x_W = np.eye(3)[0 if abs(up_W[0]) < 0.9 else 1]
    x_W = x_W - (x_W @ up_W) * up_W
    x_W /= np.linalg.norm(x_W)
    R_FW = RotationMatrix(np.stack([x_W, np.cross(up_W, x_W), up_W]))
    words = "up is from the capture's format; the floor's height is unknown"
    return Placement(RigidTransform(R_FW, np.zeros(3)), words, False)
