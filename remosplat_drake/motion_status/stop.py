"""`find_stop`: finds the cause and the place of a stop."""

from remosplat_drake.motion_status.hold import (
    Hold,
    Naming,
    moved_by,
    nearest_hold,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion_status import BASE, LOCALIZATION, SUPERVISOR
from remosplat_drake.signals.supervisor_state import (
    ARM_MODE,
    ARM_RATE,
    CLEARANCE,
    JUMP,
    LOST,
    SCANNER,
    SupervisorState,
)
from remosplat_drake.signals.tick_report import TickReport

_CAUSES = {SCANNER: BASE, LOST: LOCALIZATION}
"""Causes of stops, keyed by the supervisor's symptom. For all other symptoms,
the cause is the supervisor."""


def find_stop(
    state: SupervisorState, report: TickReport, robot: RobotModel, name: Naming
) -> Hold:
    """Finds the cause and the place of a stop.

    The place is the point of the scene that is too near, the target that has
    jumped, the link that a faulty axis moves, the base, or the first link of
    the arm. A stop by a person or by a fault of the program has no place.

    Args:
        state: The supervisor's state.
        report: The report of the latest tick.
        robot: The robot.
        name: Function that names the object at a point.
    """
    cause = _CAUSES.get(state.symptom, SUPERVISOR)
    if state.symptom == CLEARANCE and len(report.clearances):
        return nearest_hold(report, robot, name, cause)
    if state.symptom == JUMP:
        return Hold(cause, p_W=report.X_WT[:3, 3])
    return Hold(cause, link=_link(state, robot))


def _link(state: SupervisorState, robot: RobotModel) -> str:
    """Returns the name of the link that a stop concerns; empty if none."""
    description = robot.description
    body = description.base.body if description.base is not None else ""
    if state.symptom in (SCANNER, LOST):
        return body
    if state.symptom in (ARM_MODE, ARM_RATE):
        return description.arm.mount
    if state.axis is None:
        return ""
    joint = state.axis - robot.n_base
    return body if joint < 0 else moved_by(robot, description.arm.joints[joint])
