"""`SupervisorConfig`: thresholds at which the supervisor stops the robot."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config, OneOf

ROBOT_MODES = (
    "other",
    "idle",
    "move",
    "guiding",
    "reflex",
    "user_stopped",
    "automatic_error_recovery",
)
"""The arm's modes, by libfranka's names."""


@dc.dataclass
class SupervisorConfig(Config):
    """Thresholds of the safety supervisor, and their tolerated durations.

    If a threshold is exceeded for longer than its time, the robot brakes along
    the braking ramp to a latched stop.
    """

    # Whether there is a supervisor.
    enabled: bool = True
    # Greatest age of the station's measurements while the robot moves [s].
    max_status_age: Annotated[float, Interval(gt=0, le=1)] = 0.05
    # Greatest age of the controller's latest tick while the robot moves [s].
    max_tick_age: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Time by which a tick of the supervisor may be late [s]. If the control
    # loop pauses for longer, the robot is stopped.
    max_overrun: Annotated[float, Interval(ge=0, le=1)] = 0.1
    # Modes of the arm, by libfranka's names, in which the robot may move.
    robot_modes: Annotated[
        list[Annotated[str, OneOf(ROBOT_MODES, "mode")]], Len(1)
    ] = dc.field(default_factory=lambda: ["idle", "move"])
    # Smallest tolerated fraction of the commands that reach the arm in time.
    min_success_rate: Annotated[float, Interval(ge=0, le=1)] = 0.8
    # Time for which the success rate may be less than `min_success_rate` [s].
    success_rate_dwell: Annotated[float, Interval(ge=0, le=2)] = 0.2
    # Amount by which the clearance may be below the controller's smallest
    # stopping distance [m]. If the robot started nearer to the scene, it is
    # instead the amount by which the clearance may be below its largest value
    # since the start.
    clearance_margin: Annotated[float, Interval(ge=0, le=0.05)] = 0.005
    # Time for which the clearance may be below the limit of `clearance_margin`
    # [s].
    clearance_dwell: Annotated[float, Interval(ge=0, le=1)] = 0.1
    # Time for which the controller may find no feasible command and brake
    # [s].
    max_braking_time: Annotated[float, Interval(ge=0, le=10)] = 1.0
    # Greatest difference between commanded and measured velocity, as a fraction
    # of each joint's velocity limit.
    max_follow_error: Annotated[float, Interval(gt=0, le=1)] = 0.3
    # Time for which the difference may exceed `max_follow_error` [s].
    follow_dwell: Annotated[float, Interval(ge=0, le=5)] = 0.5
    # Greatest error of the position predicted by the actuator model, as a
    # multiple of the model's error bound (its tube).
    max_tracking_error: Annotated[float, Interval(gt=0, le=100)] = 1.0
    # Greatest jump of the target between two ticks [m]; no limit if absent.
    max_target_jump: Annotated[float, Interval(gt=0, le=10)] | None = None
    # Greatest age of the state of movers while the robot moves [s], if a source
    # of movers is connected. It also limits the age of the latest image of each
    # camera that detects movers.
    max_movers_age: Annotated[float, Interval(gt=0, le=2)] = 0.25
    # Greatest age of the map while the robot moves [s]; no limit if absent.
    max_map_age: Annotated[float, Interval(gt=0, le=86_400)] | None = None
