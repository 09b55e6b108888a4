"""`SupervisorConfig`: when the supervisor stops the robot."""

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
"""Modes of the arm, by libfranka's names."""


@dc.dataclass
class SupervisorConfig(Config):
    """Thresholds of the safety supervisor, and how long they may be passed."""

    # Whether there is a supervisor at all.
    enabled: bool = True
    # Oldest measurement that the robot may move on [s].
    max_status_age: Annotated[float, Interval(gt=0, le=1)] = 0.05
    # Oldest control tick that the robot may move on [s].
    max_tick_age: Annotated[float, Interval(gt=0, le=1)] = 0.1
    # The supervisor's own period may be overrun by so much [s].
    max_overrun: Annotated[float, Interval(ge=0, le=1)] = 0.1
    # Modes of the arm, by libfranka's names, in which it may be commanded.
    robot_modes: Annotated[
        list[Annotated[str, OneOf(ROBOT_MODES, "mode")]], Len(1)
    ] = dc.field(default_factory=lambda: ["idle", "move"])
    # Share of the commands that must reach the arm in time.
    min_success_rate: Annotated[float, Interval(ge=0, le=1)] = 0.8
    success_rate_dwell: Annotated[float, Interval(ge=0, le=2)] = 0.2
    # The clearance may fall so far below the smallest stopping distance; the
    # controller rides at that distance by design [m], [s].
    clearance_margin: Annotated[float, Interval(ge=0, le=0.05)] = 0.005
    clearance_dwell: Annotated[float, Interval(ge=0, le=1)] = 0.1
    # The controller may find no feasible command for so long [s].
    max_braking_time: Annotated[float, Interval(ge=0, le=10)] = 1.0
    # Largest difference of commanded and measured velocity, as a share of
    # the velocity limit of each joint, and for how long [s].
    max_follow_error: Annotated[float, Interval(gt=0, le=1)] = 0.3
    follow_dwell: Annotated[float, Interval(ge=0, le=5)] = 0.5
    # Farthest that a target may jump between two ticks; absent: any [m].
    max_target_jump: Annotated[float, Interval(gt=0, le=10)] | None = None
    # Oldest map that the robot may move on; absent: any [s].
    max_map_age: Annotated[float, Interval(gt=0, le=86_400)] | None = None
