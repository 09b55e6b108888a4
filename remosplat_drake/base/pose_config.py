"""`PoseConfig`: a pose in a configuration file."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Len
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake.base.ranges import (
    Config,
    Cosine,
    Position,
    RollPitchYawDeg,
    check_ranges,
)


@dc.dataclass
class PoseConfig(Config):
    """A pose in a file, with its rotation as either angles or a matrix."""

    # Position x, y, z of the frame's origin [m].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch and yaw, as in Drake's `RollPitchYaw` [deg]. If they are
    # absent, `rotation` applies; if both are absent, there is no rotation.
    rpy_deg: RollPitchYawDeg | None = None
    # The three rows of the rotation matrix, in place of `rpy_deg`.
    rotation: (
        Annotated[list[Annotated[list[Cosine], Len(3, 3)]], Len(3, 3)] | None
    ) = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that at most one rotation is given, and that it is valid.

        `rpy_deg` and `rotation` exclude each other. The rows of `rotation` must
        be orthonormal and right-handed.

        Yields:
            The name of an invalid field, and a description of the problem.
        """
        if self.rotation is None:
            return
        if self.rpy_deg is not None:
            yield "rpy_deg", "give `rpy_deg` or `rotation`, not both"
        matrix = np.array(self.rotation)
        deviation = np.abs(matrix @ matrix.T - np.eye(3)).max()
        if deviation > 1e-3 or np.linalg.det(matrix) < 0:
            yield (
                "rotation",
                "is not a rotation matrix (rows must be orthonormal"
                " and right-handed)",
            )


def make_transform(
    config: PoseConfig, where: str, field: str
) -> RigidTransform:
    """Returns the rigid transform of a pose.

    Args:
        config: The pose.
        where: The scenario that contains the pose, for errors: its file and
            name.
        field: Name of the pose's field, for errors.

    Raises:
        FieldError: A list has the wrong length, both rotations are given, or
            the matrix is not a rotation.
    """
    check_ranges(config, where, field)
    R = RotationMatrix()
    if config.rpy_deg is not None:
        R = RotationMatrix(RollPitchYaw(np.radians(config.rpy_deg)))
    if config.rotation is not None:
        R = RotationMatrix.ProjectToRotationMatrix(np.array(config.rotation))
    return RigidTransform(R, config.translation)
