"""Depth images of primitive scenes by casting rays: exact to rounding.

Renderers approximate cylinders by polygons, with errors of a millimetre; a
bound of millimetres must be tested with better images.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture, back_project
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

_FAR = 8.0
"""Nothing is seen beyond this depth [m]."""


def cast_capture(
    scene: PrimitiveScene,
    poses: Sequence[RigidTransform],
    width: int,
    height: int,
    fov_y: float,
) -> Capture:
    """Makes a capture of a scene with exact depths, in grey.

    Args:
        scene: The scene.
        poses: Camera poses X_WC (OpenCV axes).
        width: Width of each image [pixels].
        height: Height of each image [pixels].
        fov_y: Vertical field of view [rad].
    """
    focal = height / 2 / np.tan(fov_y / 2)
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1.0]])
    X_WC = np.array([pose.GetAsMatrix4() for pose in poses])
    depth = np.array([cast_depth(scene, K, X, width, height) for X in X_WC])
    return Capture(
        K=np.tile(K, (len(poses), 1, 1)),
        X_WC=X_WC,
        rgb=np.full((*depth.shape, 3), 128, np.uint8),
        depth=depth.astype(np.float32),
    )


def cast_depth(
    scene: PrimitiveScene, K: np.ndarray, X_WC: np.ndarray, width, height
) -> np.ndarray:
    """Computes the depth z of each pixel's centre, (h, w) [m]; 0 for none."""
    # Points of unit depth are rays.
    ones = np.ones((height, width))
    ray_C = back_project(K, ones, np.eye(4)).reshape(-1, 3)
    ray_W = ray_C @ X_WC[:3, :3].T
    depth = np.full(len(ray_W), np.inf)
    for solid in (*scene.boxes, *scene.cylinders):
        X_PW = solid.X_WP.inverse().GetAsMatrix4()
        start = X_PW[:3, :3] @ X_WC[:3, 3] + X_PW[:3, 3]
        ray_P = ray_W @ X_PW[:3, :3].T
        if isinstance(solid, Box):
            entered = _hit_box(solid, start, ray_P)
        else:
            entered = _hit_cylinder(solid, start, ray_P)
        depth = np.minimum(depth, entered)
    depth[depth > _FAR] = 0
    return depth.reshape(height, width)


def _hit_box(box: Box, start: np.ndarray, ray: np.ndarray) -> np.ndarray:
    """Depths at which rays enter a box, (n,) [m]; inf for none."""
    half = np.asarray(box.half_extents)
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (-half - start) / ray, (half - start) / ray
    return _entered(
        np.nanmax(np.minimum(a, b), axis=1), np.nanmin(np.maximum(a, b), axis=1)
    )


def _hit_cylinder(
    cylinder: Cylinder, start: np.ndarray, ray: np.ndarray
) -> np.ndarray:
    """Depths at which rays enter an upright cylinder, (n,) [m]."""
    a = (ray[:, :2] ** 2).sum(axis=1)
    b = ray[:, :2] @ start[:2]
    c = start[:2] @ start[:2] - cylinder.radius**2
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        side = (-b - root) / a, (-b + root) / a
        ends = np.array([-1, 1]) * cylinder.half_height - start[2]
        top = np.sort(ends / ray[:, 2:], axis=1)
    first = np.fmax(side[0], top[:, 0])
    last = np.where(np.isnan(root), -np.inf, np.fmin(side[1], top[:, 1]))
    return _entered(first, last)


def _entered(first: np.ndarray, last: np.ndarray) -> np.ndarray:
    return np.where((first < last) & (first > 0), first, np.inf)
