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
    """The supervisor's thresholds and limits, which never change in a run.

    Attributes:
        config: The thresholds, and how long a value may exceed each.
        dt: Control period [s].
        acceleration: Bounds on |du/dt| of the braking ramp, shape (n_u,)
            [m/s^2, rad/s^2].
        velocity: Bounds on |u|, shape (n_u,) [m/s, rad/s].
        min_clearance: Clearance below which the robot must stop [m], unless it
            started with a smaller one and comes no nearer.
        strict: Whether a command beyond the bounds on |u| and |du/dt| stops
            the robot instead of being passed on.
        obeyed: Whether the robot receives the commands. In shadow mode it does
            not, and is not checked for following them.
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
            before: Time of the previous tick [s]; NaN for none.
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
        """Makes the law for a robot.

        Args:
            config: The thresholds, and how long a value may exceed each.
            robot: The robot, for its limits.
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
        motion: Predicted motion of a robot with delay; None for a robot
            without.
        map_age: Age of the map [s].
        movers: Movers; None if nothing senses them.
        stop: Reason of a stop that a person or a program requests; empty
            without a request.
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
