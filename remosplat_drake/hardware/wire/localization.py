"""LCM messages of the base's localisation: base_localization."""

import dataclasses as dc

import numpy as np

from remosplat_drake.hardware.wire.messages.base_localization import (
    base_localization,
)
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_vector,
    from_utime,
)

_ASYMMETRY = 1e-6
"""Permitted asymmetry of a covariance, relative to its trace."""


@dc.dataclass(frozen=True, eq=False)
class BaseFix:
    """A pose in the map from a localisation; a copy is the object itself.

    Attributes:
        pose: x, y and yaw of the base or of its odometry's frame, shape (3,)
            [m, m, rad].
        covariance: Covariance of the base's x, y and yaw in the map, shape
            (3, 3).
        stamp: Time of measurement, by the clock of the odometry [s].
        frame: Name of the frame in which the pose is given.
        child_frame: Name of the frame to which the pose belongs.
    """

    pose: np.ndarray
    covariance: np.ndarray
    stamp: float
    frame: str
    child_frame: str

    def __deepcopy__(self, memo) -> "BaseFix":
        return self


def decode_localization(data: bytes) -> BaseFix:
    """Decodes and checks a localisation of the base.

    Raises:
        BrokenMessage: The packet or its covariance is invalid.
    """
    message = decode(base_localization, data)
    P = finite_vector("covariance", message.covariance, 9).reshape(3, 3)
    slack = _ASYMMETRY * max(P.trace(), 0.0)
    if np.abs(P - P.T).max() > slack or np.linalg.eigvalsh(P)[0] < -slack:
        raise BrokenMessage("covariance is not symmetric and positive")
    return BaseFix(
        pose=finite_vector("pose", message.pose, 3),
        covariance=P,
        stamp=from_utime(message.utime),
        frame=message.frame_id,
        child_frame=message.child_frame_id,
    )


def encode_localization(fix: BaseFix) -> bytes:
    """Encodes a localisation of the base."""
    message = base_localization()
    message.utime = round(1e6 * fix.stamp)
    message.frame_id, message.child_frame_id = fix.frame, fix.child_frame
    message.pose = fix.pose.tolist()
    message.covariance = fix.covariance.ravel().tolist()
    return message.encode()
