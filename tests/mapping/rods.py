"""Four rods side by side before a wall, and cameras that look at them."""

from functools import cache

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.sensor_noise import (
    sensor_noise,
    with_noise,
)
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.scene.primitive_scene import (
    Box,
    Cylinder,
    PrimitiveScene,
)

DIAMETERS = (0.003, 0.006, 0.01, 0.02)
"""Diameters of the rods [m]."""

CAMERA = WristCameraConfig()
CONFIG = MappingConfig(
    volume_lower=[0.0, -0.6, 0.2], volume_upper=[1.4, 0.6, 1.0], discs=8000
)

_MIDDLE = np.array([1.0, 0.0, 0.6])
_LENGTH = 0.4
_APART = 0.08
_TURNS = RollPitchYaw(0.05, 0.12, 0.0)
"""No rod is parallel to an axis of the pictures or of the voxels."""


def rod(number: int) -> Cylinder:
    """One of the rods, the first being the thinnest."""
    across = _APART * (number - (len(DIAMETERS) - 1) / 2)
    X_WP = RigidTransform(_TURNS, _MIDDLE + np.array([0.0, across, 0.0]))
    return Cylinder(X_WP, DIAMETERS[number] / 2, _LENGTH / 2)


def rods(*numbers: int) -> PrimitiveScene:
    """Some of the rods, a wall behind them and the floor."""
    wall = Box(RigidTransform([1.9, 0, 0.75]), np.array([0.05, 2.0, 0.75]))
    return PrimitiveScene((wall,), tuple(map(rod, numbers))).with_floor()


ALL = rods(*range(len(DIAMETERS)))


def pitch(distance: float) -> float:
    """How far apart two pixels of the camera are at a distance [m]."""
    return distance / CAMERA.intrinsics().focal_y()


@cache
def views(
    distance: float,
    sensor: str = "none",
    scene: PrimitiveScene = ALL,
    count: int = 6,
) -> Capture:
    """What cameras see of the rods in an arc of 60 degrees before them."""
    azimuth = np.linspace(-np.pi / 6, np.pi / 6, count)
    above = 0.12 * (-1.0) ** np.arange(count)
    back = np.stack(
        [-np.cos(azimuth) * np.cos(above), np.sin(azimuth), np.sin(above)],
        axis=1,
    )
    capture = render_capture(
        scene,
        [look_at(_MIDDLE + distance * side, _MIDDLE) for side in back],
        CAMERA.width,
        CAMERA.height,
        np.deg2rad(CAMERA.fov_y_deg),
    )
    return with_noise(capture, sensor_noise(sensor), seed=1)


def inside(number: int, count: int = 2000) -> np.ndarray:
    """Random points in a rod, shape (count, 3) [m]."""
    return _around(number, 0.0, DIAMETERS[number] / 2, count)


def beside(number: int, count: int = 4000) -> np.ndarray:
    """Random points up to 5 cm from a rod, shape (count, 3) [m]."""
    radius = DIAMETERS[number] / 2
    return _around(number, radius, radius + 0.05, count)


def _around(
    number: int, nearest: float, farthest: float, count: int
) -> np.ndarray:
    rng = np.random.default_rng(number)
    turn = rng.uniform(0, 2 * np.pi, count)
    away = rng.uniform(nearest, farthest, count)
    along = 0.9 * _LENGTH * rng.uniform(-0.5, 0.5, count)
    p_P = np.stack([away * np.cos(turn), away * np.sin(turn), along])
    return rod(number).X_WP.multiply(p_P).T
