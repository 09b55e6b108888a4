"""`KinematicStation` and `DynamicStation`: a scenario's `station` section."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval
from pydrake.systems.analysis import SimulatorConfig

from remosplat_drake.base.ranges import Config, OneOf

CONTACT_APPROXIMATIONS = ("lagged", "similar", "sap")
"""Names of Drake's discrete contact approximations."""


@dc.dataclass
class KinematicStation(Config):
    """A kinematic simulation: commanded velocities are reached at once.

    It is the setting of the paper.
    """

    # Speed at which the gripper's width changes [m/s].
    hand_speed: Annotated[float, Interval(gt=0, le=1)] = 0.1


@dc.dataclass
class DynamicStation(Config):
    """A dynamic simulation: inertia, motors with torque limits, contact."""

    # Time step of the discrete plant [s].
    time_step: Annotated[float, Interval(gt=0, le=0.01)] = 0.001
    # Time in which a joint's velocity error falls to 1/e while its motor is
    # strong enough [s]. It may be shorter than the time step, since the
    # contact solver treats motors implicitly.
    velocity_time_constant: Annotated[float, Interval(gt=0, le=1)] = 1e-4
    # Speed at which the gripper's width changes [m/s].
    hand_speed: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Whether the robot bumps into the scene; otherwise it passes through it.
    collide_with_scene: bool = True
    # Drake's discrete contact approximation: `lagged`, `similar` or `sap`.
    discrete_contact_approximation: Annotated[
        str, OneOf(CONTACT_APPROXIMATIONS, "contact approximation")
    ] = "lagged"


MAX_STEP = 0.05
"""Longest step of the kinematic station's integrator [s]: the settling time of
the gripper's width."""


def kinematic_simulator_config(control_period: float) -> SimulatorConfig:
    """Returns integrator settings with which the kinematic station is exact.

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
