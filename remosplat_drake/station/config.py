"""Schemas of the simulated stations: inert data for a scenario file."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval
from pydrake.systems.analysis import SimulatorConfig

from remosplat_drake.ranges import Config, OneOf, Position, RollPitchYawDeg

CONTACT_APPROXIMATIONS = ("lagged", "similar", "sap")


@dc.dataclass
class KinematicStation(Config):
    """The paper's setting: commanded velocities are reached at once."""

    # Speed at which the gripper's width changes [m/s].
    hand_speed: Annotated[float, Interval(gt=0, le=1)] = 0.1


@dc.dataclass
class DynamicStation(Config):
    """Rigid bodies with inertia, motors with torque limits, and contact."""

    # Period of the physics [s].
    time_step: Annotated[float, Interval(gt=0, le=0.01)] = 0.001
    # Time in which a joint's velocity error falls to 1/e while its motor is
    # strong enough [s]. It may be shorter than a step: motors are implicit.
    velocity_time_constant: Annotated[float, Interval(gt=0, le=1)] = 1e-4
    # Speed at which the gripper's width changes [m/s].
    hand_speed: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Whether the robot bumps into the scene; otherwise it passes through.
    collide_with_scene: bool = True
    # Contact solver: lagged, similar or sap.
    discrete_contact_approximation: Annotated[
        str, OneOf(CONTACT_APPROXIMATIONS, "contact approximation")
    ] = "lagged"


@dc.dataclass
class WristCameraConfig(Config):
    """An RGB-D camera fixed to the robot; it renders only when asked."""

    # Frame of the robot model, with axes x right, y down, z forward.
    frame: str = "wrist_camera"
    # Hand-eye calibration: the camera in that frame [m], [deg].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    rpy_deg: RollPitchYawDeg = dc.field(default_factory=lambda: [0.0] * 3)
    # Image size [pixel].
    width: Annotated[int, Interval(ge=1, le=8192)] = 320
    height: Annotated[int, Interval(ge=1, le=8192)] = 240
    # Vertical field of view [deg].
    fov_y_deg: Annotated[float, Interval(gt=0, lt=180)] = 58.0
    # Depths outside are reported as 0 (too close) and inf (too far) [m].
    min_depth: Annotated[float, Interval(gt=0, le=10)] = 0.05
    max_depth: Annotated[float, Interval(gt=0, le=100)] = 5.0

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        if not self.max_depth > self.min_depth:
            yield (
                "max_depth",
                f"must exceed min_depth {self.min_depth}, got {self.max_depth}",
            )


MAX_STEP = 0.05
"""Longest integrator step [s]: the settling time of the gripper's law."""


def kinematic_simulator_config(control_period: float) -> SimulatorConfig:
    """Integrator settings with which the kinematic station is exact.

    The fifth-order Runge-Kutta step of Drake leaves about 1e-15 m of an arc
    at 20 ms and 0.87 rad/s, less than error control would let pass, and a
    fixed step costs seven derivatives a tick and is the same everywhere.

    Args:
        control_period: Time between two commands [s].
    """
    return SimulatorConfig(
        integration_scheme="runge_kutta5",
        max_step_size=min(control_period, MAX_STEP),
        use_error_control=False,
    )
