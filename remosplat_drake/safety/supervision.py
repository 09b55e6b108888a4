"""`SupervisorLaw` and `Observation`: a supervisor's settings and inputs."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.robot.braking import periods_between
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.safety.supervisor_config import SupervisorConfig
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.tick_report import TickReport


@dc.dataclass(frozen=True, eq=False)
class SupervisorLaw:
    """The supervisor's thresholds and limits, which are constant in a run.

    Attributes:
        config: The thresholds, and the times for which each may be exceeded.
        dt: Control period [s].
        acceleration: Bounds on |du/dt| of the braking ramp, shape (n_u,)
            [m/s^2, rad/s^2].
        velocity: Bounds on |u|, shape (n_u,) [m/s, rad/s].
        min_clearance: Clearance below which the robot must stop [m]. If the
            robot started with a smaller clearance, it must stop if it comes
            nearer to the scene.
        strict: Whether a command beyond the bounds on |u| or |du/dt| stops the
            robot. If not, the command is passed on.
        obeyed: Whether the robot receives the commands. In shadow mode it does
            not, and the supervisor does not check that it follows them.
    """

    config: SupervisorConfig
    dt: float
    acceleration: np.ndarray
    velocity: np.ndarray
    min_clearance: float
    strict: bool = False
    obeyed: bool = True

    def elapsed(self, before: float, now: float) -> float:
        """Returns the time between two ticks, rounded to whole periods [s].

        Args:
            before: Time of the previous tick [s]; NaN if there is none.
            now: Time of the tick [s].
        """
        return self.dt * periods_between(before, now, self.dt)

    @staticmethod
    def make(
        config: SupervisorConfig,
        robot: RobotModel,
        dt: float,
        *,
        smallest_stopping: float,
        strict: bool = False,
        obeyed: bool = True,
    ) -> "SupervisorLaw":
        """Makes the thresholds and limits for a robot.

        Args:
            config: The thresholds, and the times for which each may be
                exceeded.
            robot: The robot, whose limits are used.
            dt: Control period [s].
            smallest_stopping: Smallest stopping distance that the controller
                may use [m].
            strict: Whether a command beyond the robot's limits stops the robot.
            obeyed: Whether the robot receives the commands.

        Raises:
            FieldError: A threshold is unusable.
        """
        check_ranges(config)
        return SupervisorLaw(
            config,
            dt,
            robot.acceleration_limit,
            robot.velocity_limit,
            smallest_stopping - config.clearance_margin,
            strict,
            obeyed,
        )


@dc.dataclass(frozen=True, eq=False)
class Observation:
    """The inputs of the supervisor at one control tick.

    Attributes:
        time: Time of the tick [s].
        command: The controller's command, shape (n_u,) [m/s, rad/s].
        report: The controller's latest report.
        status: The station's status.
        u_measured: Measured velocities, shape (n_u,) [m/s, rad/s].
        motion: Predicted motion of a robot with delay; None for a robot without
            delay.
        map_age: Age of the map [s].
        movers: The movers (moving objects); None if no sensor detects movers.
        stop: Reason of a stop that a person or a program requests; empty if
            none is requested.
        release: Whether a person or a program requests a release.
    """

    time: float
    command: np.ndarray
    report: TickReport
    status: StationStatus
    u_measured: np.ndarray
    motion: Motion | None = None
    map_age: float = 0.0
    movers: Movers | None = None
    stop: str = ""
    release: bool = False
