"""A camera on a base that sways before a table, and whose odometry drifts."""

import dataclasses as dc
from functools import cache

import numpy as np
from laden_table import THING, table
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.mapping.localization.frame_aligner import one_frame
from remosplat_drake.mapping.localization.keyframe_graph import Keyframes
from remosplat_drake.robot.planar_pose import matrix
from remosplat_drake.scene.primitive_scene import Box

DRIFT = np.array([0.016, 0.012, 0.001])
"""Velocity with which measured poses leave the true ones [m/s, m/s, rad/s]."""

PERIOD = 0.5
"""Time between two frames [s]."""

SIZE = np.array([0.1, 0.12, 0.15])
"""Edge lengths of the things on the table [m]."""


@dc.dataclass(frozen=True, eq=False)
class DrivenFrames:
    """n frames of a drive.

    Attributes:
        capture: The frames, with the poses that the odometry tells.
        X_WB: True poses of the base, shape (n, 3).
        X_OB: Measured poses of the base, shape (n, 3).
        time: When they were taken, shape (n,) [s].
    """

    capture: Capture
    X_WB: np.ndarray
    X_OB: np.ndarray
    time: np.ndarray

    def frame(self, i: int, depth: np.ndarray | None = None) -> Keyframes:
        """Prepares a frame for alignment, maybe with other depths."""
        image = Frame(
            name=f"frame {i}",
            K=self.capture.K[i],
            X_WC=self.capture.X_WC[i],
            rgb=self.capture.rgb[i],
            depth=self.capture.depth[i] if depth is None else depth,
        )
        return one_frame(image, self.X_OB[i], float(self.time[i]))


@cache
def drive(n: int = 24) -> DrivenFrames:
    """Frames of a base that sways before the table, looking at it."""
    boxes = [
        Box(
            RigidTransform(RotationMatrix.MakeZRotation(turn), [x, y, 0.5]),
            SIZE,
        )
        for x, y, turn in [
            (0.75, 0.1, 0.3),
            (0.8, -0.3, 0.0),
            (0.9, 0.38, -0.4),
            (1.25, -0.2, 0.6),
            (1.3, 0.3, 0.0),
        ]
    ]
    scene = table(THING, *boxes)
    time = PERIOD * np.arange(n)
    X_WB = np.stack(
        [
            0.1 * np.sin(time / 3),
            0.3 * np.sin(time / 2),
            0.2 * np.sin(time / 4),
        ],
        axis=1,
    )
    center = np.array([1, 0, 0.45])
    poses = [look_at(np.array([x + 0.2, y, 1.0]), center) for x, y, _ in X_WB]
    capture = render_capture(scene, poses, 160, 120)
    X_OB = X_WB + DRIFT * time[:, None]
    X_BC = np.linalg.inv(matrix(X_WB)) @ capture.X_WC
    measured = dc.replace(capture, X_WC=matrix(X_OB) @ X_BC)
    return DrivenFrames(measured, X_WB, X_OB, time)
