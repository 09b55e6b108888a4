"""Schemas of the simulated stations: inert data for a scenario file."""

import dataclasses as dc

from pydrake.systems.analysis import SimulatorConfig

from remosplat_drake.errors import RemoSplatError, unknown_name


@dc.dataclass
class KinematicStation:
    """The paper's setting: commanded velocities are reached at once."""

    # Speed at which the gripper's width changes [m/s].
    hand_speed: float = 0.1


@dc.dataclass
class DynamicStation:
    """Rigid bodies with inertia, motors with torque limits, and contact."""

    # Period of the physics [s].
    time_step: float = 0.001
    # Time in which a joint's velocity error falls to 1/e while its motor is
    # strong enough [s]. It may be shorter than a step: motors are implicit.
    velocity_time_constant: float = 1e-4
    # Speed at which the gripper's width changes [m/s].
    hand_speed: float = 0.1
    # Whether the robot bumps into the scene; otherwise it passes through.
    collide_with_scene: bool = True
    # Contact solver: lagged, similar or sap.
    discrete_contact_approximation: str = "lagged"


@dc.dataclass
class WristCameraConfig:
    """An RGB-D camera fixed to the robot; it renders only when asked."""

    # Frame of the robot model, with axes x right, y down, z forward.
    frame: str = "wrist_camera"
    # Hand-eye calibration: the camera in that frame [m], [deg].
    translation: list[float] = dc.field(default_factory=lambda: [0.0] * 3)
    rpy_deg: list[float] = dc.field(default_factory=lambda: [0.0] * 3)
    # Image size [pixel].
    width: int = 320
    height: int = 240
    # Vertical field of view [deg].
    fov_y_deg: float = 58.0
    # Depths outside are reported as 0 (too close) and inf (too far) [m].
    min_depth: float = 0.05
    max_depth: float = 5.0


CONTACT_APPROXIMATIONS = ("lagged", "similar", "sap")


def check_dynamic_config(config: DynamicStation) -> None:
    """Raises `RemoSplatError` where a value is unusable."""
    for name in ("time_step", "velocity_time_constant", "hand_speed"):
        _check_positive("station", name, getattr(config, name))
    approximation = config.discrete_contact_approximation
    if approximation not in CONTACT_APPROXIMATIONS:
        raise RemoSplatError(
            "station.discrete_contact_approximation: "
            + unknown_name(
                "contact approximation", approximation, CONTACT_APPROXIMATIONS
            )
        )


def check_kinematic_config(config: KinematicStation) -> None:
    """Raises `RemoSplatError` where a value is unusable."""
    _check_positive("station", "hand_speed", config.hand_speed)


def check_camera_config(config: WristCameraConfig) -> None:
    """Raises `RemoSplatError` where a value is unusable."""
    for name in ("width", "height", "min_depth", "max_depth"):
        _check_positive("wrist_camera", name, getattr(config, name))
    if not 0 < config.fov_y_deg < 180:
        raise RemoSplatError(
            "wrist_camera.fov_y_deg: must be between 0 and 180,"
            f" got {config.fov_y_deg}"
        )
    if config.max_depth <= config.min_depth:
        raise RemoSplatError(
            "wrist_camera.max_depth: must exceed min_depth"
            f" {config.min_depth}, got {config.max_depth}"
        )
    for name in ("translation", "rpy_deg"):
        if len(getattr(config, name)) != 3:
            raise RemoSplatError(f"wrist_camera.{name}: expected 3 numbers")


def _check_positive(where: str, name: str, value: float) -> None:
    if not value > 0:
        raise RemoSplatError(f"{where}.{name}: must be positive, got {value!r}")


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
