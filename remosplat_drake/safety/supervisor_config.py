"""`SupervisorConfig`: limits at which the safety supervisor stops the robot."""

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
"""Names of the arm's modes, as libfranka has them."""


@dc.dataclass
class SupervisorConfig(Config):
    """Thresholds of the safety supervisor, and how long they may be passed.

    Beyond one of them the robot ramps down into a latched stop.
    """

    # Whether there is a supervisor at all.
    enabled: bool = True
    # Greatest age of the station's measurements while the robot moves [s].
    max_status_age: Annotated[float, Interval(gt=0, le=1)] = 0.05
    # Greatest age of the controller's latest tick while the robot moves [s].
    max_tick_age: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # Time by which the supervisor may be late for its own period [s]: a loop
    # that stood still for longer is stopped.
    max_overrun: Annotated[float, Interval(ge=0, le=1)] = 0.1
    # Modes of the arm, by libfranka's names, in which the robot may move.
    robot_modes: Annotated[
        list[Annotated[str, OneOf(ROBOT_MODES, "mode")]], Len(1)
    ] = dc.field(default_factory=lambda: ["idle", "move"])
    # Least share of the commands that must reach the arm in time.
    min_success_rate: Annotated[float, Interval(ge=0, le=1)] = 0.8
    # Time for which fewer commands may reach the arm [s].
    success_rate_dwell: Annotated[float, Interval(ge=0, le=2)] = 0.2
    # How far the clearance may fall below the controller's smallest stopping
    # distance, at which it rides by design, or below what a robot that started
    # nearer to the scene has reached since [m].
    clearance_margin: Annotated[float, Interval(ge=0, le=0.05)] = 0.005
    # Time for which the clearance may be smaller than that [s].
    clearance_dwell: Annotated[float, Interval(ge=0, le=1)] = 0.1
    # Time for which the controller may find no feasible command and brake
    # [s].
    max_braking_time: Annotated[float, Interval(ge=0, le=10)] = 1.0
    # Greatest difference between commanded and measured velocity, as a share
    # of each joint's velocity limit.
    max_follow_error: Annotated[float, Interval(gt=0, le=1)] = 0.3
    # Time for which the difference may be greater [s].
    follow_dwell: Annotated[float, Interval(ge=0, le=5)] = 0.5
    # Greatest error of the position that the actuators' model predicts, as a
    # multiple of the model's own tube.
    max_tracking_error: Annotated[float, Interval(gt=0, le=100)] = 1.0
    # Greatest jump of the target between two ticks [m]; absent: any.
    max_target_jump: Annotated[float, Interval(gt=0, le=10)] | None = None
    # Greatest age of what is known to move while the robot moves [s], where
    # anything is told; and of the latest image of a camera that watches.
    max_movers_age: Annotated[float, Interval(gt=0, le=2)] = 0.25
    # Greatest age of the map while the robot moves [s]; absent: any.
    max_map_age: Annotated[float, Interval(gt=0, le=86_400)] | None = None
