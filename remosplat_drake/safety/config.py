"""`SupervisorConfig`: when the supervisor stops the robot."""

import dataclasses as dc

from remosplat_drake.errors import FieldError


@dc.dataclass
class SupervisorConfig:
    """Thresholds of the safety supervisor, and how long they may be passed."""

    # Whether there is a supervisor at all.
    enabled: bool = True
    # Oldest measurement that the robot may move on [s].
    max_status_age: float = 0.05
    # Oldest control tick that the robot may move on [s].
    max_tick_age: float = 0.1
    # The supervisor's own period may be overrun by so much [s].
    max_overrun: float = 0.1
    # Modes of the arm, by libfranka's names, in which it may be commanded.
    robot_modes: list[str] = dc.field(default_factory=lambda: ["idle", "move"])
    # Share of the commands that must reach the arm in time.
    min_success_rate: float = 0.8
    success_rate_dwell: float = 0.2
    # The clearance may fall so far below the smallest stopping distance; the
    # controller rides at that distance by design [m], [s].
    clearance_margin: float = 0.005
    clearance_dwell: float = 0.1
    # The controller may find no feasible command for so long [s].
    max_braking_time: float = 1.0
    # Largest difference of commanded and measured velocity, as a share of
    # the velocity limit of each joint, and for how long [s].
    max_follow_error: float = 0.3
    follow_dwell: float = 0.5
    # Farthest that a target may jump between two ticks; absent: any [m].
    max_target_jump: float | None = None
    # Oldest map that the robot may move on; absent: any [s].
    max_map_age: float | None = None


def check_supervisor(config: SupervisorConfig, where: str) -> None:
    """Checks the ranges that types cannot express.

    Raises:
        FieldError: A value is out of range; names the field.
    """
    for field in dc.fields(config):
        value = getattr(config, field.name)
        if isinstance(value, float) and not value >= 0:
            raise FieldError(
                where,
                f"supervisor.{field.name}",
                f"must not be negative, got {value}",
            )
    if config.min_success_rate > 1:
        raise FieldError(
            where,
            "supervisor.min_success_rate",
            f"must lie in [0, 1], got {config.min_success_rate}",
        )
    if not config.robot_modes:
        raise FieldError(
            where, "supervisor.robot_modes", "allows no mode at all"
        )
