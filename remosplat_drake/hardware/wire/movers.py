"""Encodes and decodes movers (moving objects) in LCM messages, mover_list."""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.wire.messages.mover_list import (
    mover_list as Message,
)
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_number,
    finite_vector,
    from_utime,
    to_utime,
)
from remosplat_drake.scene.mover import MOST, Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera

MOST_CAMERAS = 20
"""Largest number of cameras in a message."""

LONGEST_NAME = 100
"""Greatest length of a name; longer names are cut off."""

_BOUNDS = ("max_speed", "max_acceleration", "position_error", "velocity_error")


def encode_movers(movers: Movers) -> bytes:
    """Encodes movers and the space that cameras observe.

    Args:
        movers: The known movers, with a stamp by the wall clock [s].
    """
    message = Message()
    message.utime, message.version = to_utime(movers.stamp), Message.VERSION
    message.num_movers = len(movers)
    message.name = [mover.name for mover in movers]
    message.half_extents = [mover.half_extents.tolist() for mover in movers]
    message.position = [_position(mover.X_WM) for mover in movers]
    message.quaternion = [_quaternion(mover.X_WM) for mover in movers]
    message.velocity = [mover.v_WM.tolist() for mover in movers]
    message.angular_velocity = [mover.w_WM.tolist() for mover in movers]
    for field in ("radius", *_BOUNDS):
        setattr(message, field, [getattr(mover, field) for mover in movers])
    cameras = movers.cameras
    message.num_cameras = len(cameras)
    message.camera = [camera.name for camera in cameras]
    message.seen_utime = [to_utime(camera.seen) for camera in cameras]
    message.camera_position = [_position(camera.X_WC) for camera in cameras]
    message.camera_quaternion = [_quaternion(c.X_WC) for c in cameras]
    for field in ("least_tangent", "greatest_tangent"):
        values = [getattr(camera, field).tolist() for camera in cameras]
        setattr(message, field, values)
    for field in ("problem", "near", "far"):
        setattr(message, field, [getattr(c, field) for c in cameras])
    return message.encode()


def _position(X_WF: RigidTransform) -> list[float]:
    return X_WF.translation().tolist()


def _quaternion(X_WF: RigidTransform) -> list[float]:
    return X_WF.rotation().ToQuaternion().wxyz().tolist()


def decode_movers(data: bytes) -> Movers:
    """Decodes and checks movers and the space that cameras observe.

    One invalid value makes the whole message invalid, since the values of the
    other movers may be wrong, too.

    Args:
        data: The encoded packet.

    Raises:
        BrokenMessage: The packet is another message or another version, has no
            stamp, or has too many movers or cameras, or a value is not finite
            or is impossible. The error names the field.
    """
    message = decode(Message, data)
    if message.version != Message.VERSION:
        raise BrokenMessage(
            f"has version {message.version}; valid: {Message.VERSION}"
        )
    if message.utime <= 0:
        raise BrokenMessage("has no stamp")
    for what, number, most in (
        ("movers", message.num_movers, MOST),
        ("cameras", message.num_cameras, MOST_CAMERAS),
    ):
        if not 0 <= number <= most:
            raise BrokenMessage(
                f"has {number} {what}; at most {most} are allowed"
            )
    try:
        return Movers(
            from_utime(message.utime),
            [_mover(message, i) for i in range(message.num_movers)],
            [_camera(message, i) for i in range(message.num_cameras)],
        )
    except FieldError as error:
        raise BrokenMessage(str(error)) from error


def _mover(message: Message, i: int) -> Mover:
    where = f"movers[{i}]."

    def vector(field: str, size: int = 3) -> np.ndarray:
        return finite_vector(where + field, getattr(message, field)[i], size)

    return Mover(
        message.name[i][:LONGEST_NAME],
        _pose(
            where + "quaternion", vector("quaternion", 4), vector("position")
        ),
        vector("half_extents"),
        finite_number(f"{where}radius", message.radius[i]),
        vector("velocity"),
        vector("angular_velocity"),
        **{
            field: finite_number(where + field, getattr(message, field)[i])
            for field in _BOUNDS
        },
    )


def _camera(message: Message, i: int) -> MoverCamera:
    where = f"cameras[{i}]."
    position = message.camera_position[i]
    quaternion = message.camera_quaternion[i]
    return MoverCamera(
        message.camera[i][:LONGEST_NAME],
        _pose(
            where + "quaternion",
            finite_vector(where + "quaternion", quaternion, 4),
            finite_vector(where + "position", position, 3),
        ),
        np.array(message.least_tangent[i]),
        np.array(message.greatest_tangent[i]),
        message.near[i],
        message.far[i],
        from_utime(message.seen_utime[i]),
        message.problem[i][:LONGEST_NAME],
    )


def _pose(where: str, wxyz: np.ndarray, p: np.ndarray) -> RigidTransform:
    length = float(np.linalg.norm(wxyz))
    if not 1e-6 < length < 1e6:
        raise BrokenMessage(f"{where} has the norm {length:g}, not 1")
    return RigidTransform(RotationMatrix(Quaternion(wxyz / length)), p)
