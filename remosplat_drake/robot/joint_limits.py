"""`JointLimits`: limits of position, speed, acceleration and jerk."""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.robot_description import RobotDescription


class JointLimits(NamedTuple):
    """The limits of a robot's configuration q and command u.

    Attributes:
        velocity: Symmetric bounds on u, shape (n_u,) [m/s, rad/s].
        acceleration: Bounds on |du/dt|, shape (n_u,) [m/s^2, rad/s^2].
        jerk: Bounds on |d2u/dt2|, shape (n_u,) [m/s^3, rad/s^3]; infinite where
            the description states none.
        lower: Lower limits of q, shape (n_q,) [m, rad]; infinite for the base.
        upper: Upper limits of q, shape (n_q,) [m, rad]; infinite for the base.
    """

    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @staticmethod
    def read(
        description: RobotDescription, plant: MultibodyPlant
    ) -> "JointLimits":
        """Reads the limits from a robot's description and its model.

        Args:
            description: The description, which states the limits of u.
            plant: A plant with the robot's model, which states the limits of q.

        Raises:
            FieldError: The description has too many or too few numbers, or a
                joint has no range.
        """
        _check_lengths(description)
        arm = description.arm.joints
        joints = [plant.GetJointByName(name) for name in arm]
        base = np.full(
            len(description.base.joints) if description.base else 0, np.inf
        )
        lower = [joint.position_lower_limits()[0] for joint in joints]
        upper = [joint.position_upper_limits()[0] for joint in joints]
        for i, name in enumerate(arm):
            if not lower[i] < upper[i]:
                raise FieldError(
                    description.source,
                    f"arm.joints[{i}]",
                    f"{name} has no range, from {lower[i]:g} to"
                    f" {upper[i]:g}; put it under `locked`",
                )
        velocity = np.array(description.velocity_limits, float)
        jerk = description.jerk_limits
        return JointLimits(
            velocity,
            np.array(description.acceleration_limits, float),
            np.array([np.inf] * (len(velocity) - len(jerk)) + jerk, float),
            np.concatenate([-base, lower]),
            np.concatenate([base, upper]),
        )


def _check_lengths(description: RobotDescription) -> None:
    arm = description.arm.joints
    n_u = description.n_base + len(arm)
    for name in ("velocity_limits", "acceleration_limits"):
        if len(getattr(description, name)) != n_u:
            raise FieldError(
                description.source,
                name,
                f"expected {n_u} numbers (base, then arm)",
            )
    if description.jerk_limits and len(description.jerk_limits) != len(arm):
        raise FieldError(
            description.source,
            "jerk_limits",
            "expected one number for each arm joint, or none",
        )
    if description.actuators and len(description.actuators) != n_u:
        raise FieldError(
            description.source,
            "actuators",
            f"expected {n_u} entries (base, then arm), or none",
        )
    if len(description.home) != len(arm):
        raise FieldError(
            description.source, "home", "expected one number for each arm joint"
        )
