"""A camera on a base that goes around a table, and whose odometry drifts."""

import dataclasses as dc
from functools import cache

import numpy as np
from laden_table import THING, table
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.mapping.localization.planar_pose import (
    composed,
    matrix,
    odometry_frame,
)
from remosplat_drake.scene.primitive_scene import Box, Cylinder

DRIFT = np.array([0.016, 0.012, 0.001])
"""Velocity with which the odometry's frame leaves W [m/s, m/s, rad/s]."""

PERIOD = 2.0
"""Time between two frames [s]."""


@dc.dataclass(frozen=True, eq=False)
class DrivenFrames:
    """Frames of a drive.

    Attributes:
        capture: The frames, with the poses that the odometry tells.
        X_WC: True poses of the cameras, shape (n, 4, 4).
        X_WB: True poses of the base, shape (n, 3).
        X_OB: Measured poses of the base, shape (n, 3).
        keys: Names and times.
    """

    capture: Capture
    X_WC: np.ndarray
    X_WB: np.ndarray
    X_OB: np.ndarray
    keys: list[tuple[str, float]]


@cache
def drive(n: int = 12) -> DrivenFrames:
    """Frames of a base that sways before the table, looking at it."""
    scene = table(
        THING,
        Box(RigidTransform([1.3, 0.3, 0.5]), np.array([0.08, 0.1, 0.06])),
        Box(RigidTransform([0.8, -0.3, 0.47]), np.array([0.06, 0.06, 0.08])),
    )
    scene = dc.replace(
        scene,
        cylinders=tuple(
            Cylinder(RigidTransform([x, y, 0.55]), 0.05, 0.12)
            for x, y in [(0.75, 0.1), (0.95, -0.35), (0.9, 0.38), (1.25, -0.2)]
        ),
    )
    time = PERIOD * np.arange(n)
    X_WB = np.stack(
        [
            -0.3 + 0.1 * np.sin(time / 9),
            0.3 * np.sin(time / 5),
            0.2 * np.sin(time / 7),
        ],
        axis=1,
    )
    center = np.array([1, 0, 0.45])
    poses = [look_at(np.array([x + 0.5, y, 1.0]), center) for x, y, _ in X_WB]
    capture = render_capture(scene, poses, 320, 240)
    X_OB = np.stack(
        [
            composed(odometry_frame(np.zeros(3), DRIFT * t), X)
            for t, X in zip(time, X_WB, strict=True)
        ]
    )
    X_BC = np.linalg.inv(matrix(X_WB)) @ capture.X_WC
    return DrivenFrames(
        dc.replace(capture, X_WC=matrix(X_OB) @ X_BC),
        capture.X_WC,
        X_WB,
        X_OB,
        [(f"frame {i + 1}", float(t)) for i, t in enumerate(time)],
    )
