"""Converts Drake's `CameraConfig` to a `WristCameraConfig`."""

from collections.abc import Iterator

import numpy as np
from pydrake.math import RollPitchYaw
from pydrake.systems.sensors import CameraConfig

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import field_types
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig

_SOURCES = {
    "width": "width",
    "height": "height",
    "fov_y_deg": "focal",
    "min_depth": "z_near",
    "max_depth": "z_far",
    "frame": "X_PB",
    "translation": "X_PB",
    "rpy_deg": "X_PB",
}
"""Fields of Drake's `CameraConfig`, keyed by fields of `WristCameraConfig`."""

_FREE = ("name", "depth")
"""Ignored fields: the name, which has no effect, and the flag for depth, which
is always rendered."""


def make_wrist_camera(config: CameraConfig) -> WristCameraConfig:
    """Converts a Drake camera to a `WristCameraConfig`.

    Drake's frame B of the camera has the axes x right, y down, z forward.

    Args:
        config: A configuration for which `camera_problems` yields nothing.

    Raises:
        FieldError: A value is out of the range of the field in
            `WristCameraConfig`.
    """
    X_PB = config.X_PB.GetDeterministicValue()
    fov_y = 2 * np.arctan(config.height / (2 * config.focal_y()))
    return WristCameraConfig(
        frame=config.X_PB.base_frame,
        translation=X_PB.translation().tolist(),
        rpy_deg=np.rad2deg(RollPitchYaw(X_PB.rotation()).vector()).tolist(),
        width=config.width,
        height=config.height,
        fov_y_deg=float(np.rad2deg(fov_y)),
        min_depth=config.z_near,
        max_depth=config.z_far,
    )


def camera_problems(config: CameraConfig) -> Iterator[tuple[str, str]]:
    """Yields the settings of a Drake camera that are not supported.

    Args:
        config: A configuration with finite numbers.

    Yields:
        A field of `CameraConfig`, and the problem with its value.
    """
    new = CameraConfig()
    for name in field_types(CameraConfig):
        if name in (*_SOURCES.values(), *_FREE):
            continue
        if repr(getattr(config, name)) != repr(getattr(new, name)):
            yield name, "the wrist camera does not support it: remove it"
    if not config.X_PB.base_frame:
        yield "X_PB.base_frame", "must be a frame of the robot"
        return
    try:
        if not np.isclose(config.focal_x(), config.focal_y(), rtol=1e-6):
            yield "focal", "pixels must be square: set one of x and y to null"
        make_wrist_camera(config)
    except FieldError as error:
        field, _, _ = error.field.partition("[")
        yield _SOURCES[field], error.problem
    except RuntimeError as error:
        yield "focal", " ".join(str(error).split())
