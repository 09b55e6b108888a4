"""`KinematicStation`, `DynamicStation`: the section `station` of scenarios."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated, Protocol

import numpy as np
from annotated_types import Interval
from pydrake.systems.analysis import (
    ApplySimulatorConfig,
    GetIntegrationSchemes,
    Simulator,
    SimulatorConfig,
)
from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.base.errors import unknown_name
from remosplat_drake.base.ranges import Config, OneOf, Position
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.station_camera import StationCamera

CONTACT_APPROXIMATIONS = ("lagged", "similar", "sap")
"""Names of Drake's discrete contact approximations."""


@dc.dataclass
class KinematicStation(Config):
    """Settings of a kinematic simulation, as in the paper.

    The robot reaches commanded velocities at once.
    """

    # Speed at which the gripper's width changes [m/s].
    hand_speed: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Rate at which the measured x, y and yaw of the base drift away from the
    # true values, to simulate the drift of odometry [m/s, m/s, rad/s].
    odometry_drift: Position = dc.field(default_factory=lambda: [0.0, 0.0, 0.0])


@dc.dataclass
class DynamicStation(Config):
    """Settings of a simulation with inertia, torque limits and contact."""

    # Time step of the discrete plant [s].
    time_step: Annotated[float, Interval(gt=0, le=0.01)] = 0.001
    # Time constant of a joint's velocity error, while the motor is below its
    # torque limit [s]. It may be shorter than the time step, since the contact
    # solver treats motors implicitly.
    velocity_time_constant: Annotated[float, Interval(gt=0, le=1)] = 1e-4
    # Speed at which the gripper's width changes [m/s].
    hand_speed: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Whether the robot collides with the scene. If not, it passes through the
    # scene.
    collide_with_scene: bool = True
    # Hydroelastic modulus of the fingers' pads [Pa]. A larger modulus makes the
    # pads harder.
    pad_modulus: Annotated[float, Interval(ge=1e4, le=1e9)] = 1e7
    # Coefficient of friction of objects. That of the pads is 1.5, and that of
    # the scene 0.6. A pair in contact has the harmonic mean of its two
    # coefficients.
    object_friction: Annotated[float, Interval(ge=0, le=5)] = 1.0
    # Drake's discrete contact approximation: `lagged`, `similar` or `sap`.
    discrete_contact_approximation: Annotated[
        str, OneOf(CONTACT_APPROXIMATIONS, "contact approximation")
    ] = "lagged"


class StationMaker(Protocol):
    """Protocol of settings that make another kind of station.

    In a scenario, such settings replace `KinematicStation` or
    `DynamicStation`.
    """

    def make(
        self,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        q0: np.ndarray,
        camera: StationCamera | None,
    ) -> Diagram:
        """Builds the station.

        Args:
            robot: The robot; its description names the ports.
            scene: The solids in the scene; None for an empty scene.
            q0: Configuration at the start, shape (n_q,) [m, rad].
            camera: The wrist camera to add; None for no camera.

        Returns:
            A diagram with the ports of `signals.station_ports`.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        ...


MAX_STEP = 0.05
"""Upper limit of the steps of the kinematic station's integrator [s]. It equals
the time constant of the gripper's width."""


def kinematic_simulator_config(control_period: float) -> SimulatorConfig:
    """Returns simulator settings with which the kinematic station is exact.

    The error of Drake's fifth-order Runge-Kutta step is about 1e-15 m for an
    arc of 20 ms at 0.87 rad/s, less than the usual tolerance of error control.
    A fixed step needs seven evaluations of the derivatives per tick, and gives
    the same results on all machines.

    Args:
        control_period: Time between two commands [s].
    """
    return SimulatorConfig(
        integration_scheme="runge_kutta5",
        max_step_size=min(control_period, MAX_STEP),
        use_error_control=False,
    )


def simulator_problems(config: SimulatorConfig) -> Iterator[tuple[str, str]]:
    """Yields simulator settings with which no run is possible.

    Drake itself accepts a step of zero, with which a simulation never ends.

    Args:
        config: Drake's settings, with finite numbers.

    Yields:
        The name of a setting, and its problem.
    """
    for name in ("max_step_size", "accuracy"):
        if getattr(config, name) <= 0:
            yield name, f"must be positive, got {getattr(config, name)}"
    if config.target_realtime_rate < 0:
        rate = config.target_realtime_rate
        yield "target_realtime_rate", f"must not be negative, got {rate}"
    if config.start_time != 0:
        yield "start_time", f"must be 0, got {config.start_time}"
    scheme, schemes = config.integration_scheme, GetIntegrationSchemes()
    if scheme not in schemes:
        problem = unknown_name("integration scheme", scheme, schemes)
        yield "integration_scheme", problem
    try:
        ApplySimulatorConfig(config, Simulator(ConstantVectorSource([0.0])))
    except RuntimeError as error:
        yield "", str(error)
