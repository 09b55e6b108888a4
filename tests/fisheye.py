"""Images of an equidistant fisheye lens."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform
from scipy.ndimage import map_coordinates

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.scene.primitive_scene import PrimitiveScene

_SAME = 0.02
"""Neighbours whose inverse depths differ by less are of one surface."""


def fisheye_capture(
    scene: PrimitiveScene,
    poses: list[RigidTransform],
    size: tuple[int, int],
    half_angle: float,
) -> Capture:
    """Makes images of r = f theta whose K is told as if it were a pinhole's.

    Args:
        scene: The scene, of flat things: their inverse depth is linear.
        poses: Camera poses X_WC (OpenCV axes).
        size: Width and height of the images [pixels].
        half_angle: Angle from the middle to the right edge [rad].
    """
    width, height = size
    focal = width / 2 / half_angle
    edge = np.tan(np.hypot(width, height) / 2 / focal)
    span = 2 * int(np.ceil(1.02 * edge * focal))
    fov_y = 2 * np.arctan(span / 2 / focal)
    wide = render_capture(scene, poses, span, span, fov_y=fov_y)
    v, u = np.indices((height, width)) + 0.5
    xy = np.stack([v - height / 2, u - width / 2]) / focal
    theta = np.linalg.norm(xy, axis=0)
    place = xy * np.tan(theta) / theta * focal + span / 2 - 0.5
    depth = np.zeros((len(poses), height, width), np.float32)
    for view, z in enumerate(wide.depth):
        inverse = 1 / np.where(z > 0, z, np.inf)
        smooth = map_coordinates(inverse, place, order=1)
        nearest = map_coordinates(inverse, place, order=0)
        one = (nearest > 0) & (np.abs(smooth - nearest) < _SAME * nearest)
        depth[view][one] = 1 / smooth[one]
    row, column = np.rint(place).astype(int)
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    return dc.replace(
        wide,
        K=np.tile(K, (len(poses), 1, 1)),
        rgb=wide.rgb[:, row, column],
        depth=depth,
    )
