"""Rest: a robot at a reached target stops moving.

At a reached target, secondary costs continue to move a redundant robot: the end
effector does not move, but base and arm drift in the null space of the task. A
dead band with hysteresis ends this motion. The robot comes to rest if the
target is reached and has not changed, and if its error no longer decreases. It
moves again if the target changes, if the error increases by more than the dead
band, if the clearance falls below the stopping distance by more than the dead
band, or if a mover comes near.
"""

import dataclasses as dc
import math
from collections.abc import Callable

import numpy as np

from remosplat_drake.controller.rest_config import RestConfig
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.robot.braking import braking_command
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.tick_report import BRAKING, TickReport

_SETTLED = 0.25
"""While the robot comes to rest, an error may still decrease by this fraction
of the dead band."""

_CHECK_PERIOD = 0.1
"""Time between two checks of the errors of a moving robot [s]."""


@dc.dataclass(frozen=True, eq=False)
class RestRule:
    """The conditions of rest.

    Attributes:
        config: The dead band.
        arrived: Function that returns whether a `PoseError` counts as arrival.
    """

    config: RestConfig
    arrived: Callable[[PoseError], bool]


@dc.dataclass(frozen=True, eq=False)
class Rest:
    """The state of rest at a target; copying returns the object itself.

    Attributes:
        aim: The aim at whose targets the robot is; None if there is none.
        since: Time since which the errors have not decreased [s].
        errors: Errors at the time `since`, shape (k + 1, 2). For each target,
            they are the distance [m] and the angle [rad]. The last row is the
            amount by which the clearance is below the stopping distance [m],
            and 0.
        is_still: Whether the robot rests.
        checked: Time of the latest check of the errors [s].
    """

    aim: Aim | None = None
    since: float = math.nan
    errors: np.ndarray = dc.field(default_factory=lambda: np.zeros((1, 2)))
    is_still: bool = False
    checked: float = -math.inf

    def __deepcopy__(self, memo) -> "Rest":
        return self


def advance_rest(
    rule: RestRule, law: ReactiveLaw, rest: Rest, report: TickReport
) -> Rest:
    """Decides at a tick whether the robot rests.

    Args:
        rule: The conditions of rest.
        law: The control law.
        rest: The state at the previous tick.
        report: The report of the tick.
    """
    time, config = report.time, rule.config
    if not config.enabled:
        return rest
    if not rest.is_still and 0.0 <= time - rest.checked < _CHECK_PERIOD:
        return rest
    errors = _errors(rule, law, report)
    if errors is None:
        return Rest(checked=time)
    anew = Rest(report.aim, time, errors, checked=time)
    if rest.aim is None or not rest.aim.equals(report.aim):
        return anew
    change = (errors - rest.errors) / config.bands
    if rest.is_still:
        return rest if change.max() <= 1.0 else anew
    if change.min() < -_SETTLED:
        return anew
    settled = time - rest.since >= config.settling_time
    return dc.replace(rest, is_still=settled, checked=time)


def at_rest(
    law: ReactiveLaw,
    report: TickReport,
    u_previous: np.ndarray,
    periods: float = 1.0,
) -> TickReport:
    """Returns the report of a tick at which the robot rests.

    The command in the report is the next step of the braking ramp, which was
    verified with the previous command.

    Args:
        law: The control law.
        report: The report of the tick without rest.
        u_previous: The command that was sent last, shape (n_u,).
        periods: Number of control periods since that command was sent.
    """
    limit = law.robot.acceleration_limit
    ramp = braking_command(u_previous, limit, periods * law.dt)
    return dc.replace(report, command=ramp)


def _errors(
    rule: RestRule, law: ReactiveLaw, report: TickReport
) -> np.ndarray | None:
    """Returns `Rest.errors`; None if the robot must move."""
    near = report.separation
    if report.status == BRAKING or report.aim.has_line:
        return None
    if near is not None and near.distance <= law.movers.influence:
        return None
    errors = report.aim.errors(law.robot.end_effector_poses(report.q))
    if not report.aim.is_reached_by(errors, rule.arrived):
        return None
    lacking = law.collision.stopping - report.clearances.minimum()
    rows = [(error.distance, error.angle) for error in errors]
    return np.array([*rows, (max(lacking, 0.0), 0.0)])
