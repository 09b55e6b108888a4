"""What the supervisor knows and sees: plain values."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervisor_config import SupervisorConfig
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.tick_report import TickReport


@dc.dataclass(frozen=True, eq=False)
class SupervisorLaw:
    """What stays the same from tick to tick.

    Attributes:
        config: Thresholds.
        dt: Control period [s].
        acceleration: Bounds on |du/dt| of the braking ramp, shape (n_u,).
        start_acceleration: The same for the first commands; infinite where
            the controller has no such bounds either, shape (n_u,).
        velocity: Bounds on |u|, shape (n_u,).
        min_clearance: A clearance below is wrong [m].
    """

    config: SupervisorConfig
    dt: float
    acceleration: np.ndarray
    start_acceleration: np.ndarray
    velocity: np.ndarray
    min_clearance: float

    @staticmethod
    def make(
        config: SupervisorConfig,
        robot: RobotModel,
        dt: float,
        *,
        smallest_stopping: float,
        bounded_start: bool = True,
    ) -> "SupervisorLaw":
        """The law for a robot.

        Args:
            config: Thresholds.
            robot: Its limits.
            dt: Control period [s].
            smallest_stopping: Closest that the controller goes by design [m].
            bounded_start: Whether the first commands must respect the
                acceleration limits.

        Raises:
            FieldError: A threshold is unusable.
        """
        check_ranges(config)
        limit = robot.acceleration_limit
        return SupervisorLaw(
            config,
            dt,
            limit,
            limit if bounded_start else np.full_like(limit, np.inf),
            robot.velocity_limit,
            smallest_stopping - config.clearance_margin,
        )


@dc.dataclass(frozen=True, eq=False)
class Observation:
    """What the supervisor sees at one tick.

    Attributes:
        time: Time of the tick [s].
        command: The wanted velocity, shape (n_u,).
        report: The controller's latest.
        status: The station's.
        u_measured: Measured velocities, shape (n_u,).
        map_age: Age of the map [s].
        stop: Why somebody asks for a stop; empty if nobody does.
        release: Whether somebody releases the stop.
    """

    time: float
    command: np.ndarray
    report: TickReport
    status: StationStatus
    u_measured: np.ndarray
    map_age: float = 0.0
    stop: str = ""
    release: bool = False
