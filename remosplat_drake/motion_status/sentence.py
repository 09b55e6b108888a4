"""Formats the robot's state as one sentence."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.planning.plan import (
    CRAMPED,
    CUT_OFF,
    UNREACHED,
)
from remosplat_drake.motion_status.hold import Hold
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import thing as things
from remosplat_drake.signals.binding import (
    JOINT_LIMIT,
    MOVER,
    SELF_COLLISION,
)
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.supervisor_state import (
    STARTING,
    STOPPING,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.target import Target
from remosplat_drake.task.target_sequence import TargetProgress

CIRCLING = 10.0
"""If the robot has made no progress for this time, the sentence states the time
without progress [s]."""

_ADVICE = {
    things.MAP: "move or turn the target",
    things.SOLID: "move or turn the target",
    things.FLOOR: "move the target up",
    things.UNSEEN: "add a frame that sees it",
    JOINT_LIMIT: "turn the target",
    SELF_COLLISION: "turn the target",
    MOVER: "it continues when that has passed",
    states.VERIFICATION: "there would be no way to stop in time",
    states.NOT_OBEYED: "see whether the robot is enabled",
    states.BASE: "the base is not allowed to drive: move it nearer",
    states.NOTHING: "nothing is in the way, it may be out of reach",
}
"""Advice for a person, or an explanation, for each cause."""

_CAUSES_WITHOUT_PATH = {
    UNREACHED: states.NO_CONFIGURATION,
    CRAMPED: states.NO_CONFIGURATION,
    CUT_OFF: states.NO_PATH,
}
"""For each reason why there is no path: the cause of a standstill if no
constraint is active."""

_OF_THE_TARGET = (states.BASE, states.NO_CONFIGURATION, states.NO_PATH)
"""Causes that the page displays at the target."""

_NEAR = 0.1
"""Distance below which the sentence uses millimetres and degrees [m]."""


@dc.dataclass(frozen=True, eq=False)
class Situation:
    """The inputs of the sentence that describes the robot's state.

    Attributes:
        error: The pose error of the end effector at the present target; the
            largest error if there are several targets.
        target: The present target; None for a plain pose.
        effector: Name of the target's end effector; empty if the robot has only
            one.
        beside_line: Distance of the end effector from the line to the target
            [m]; NaN if there is no line.
        is_there: Whether the end effector has arrived at the target.
        hold: The cause that keeps the robot from moving; None while it moves.
        stop: The cause of a stop by the supervisor; None if the cause is
            unknown, or if there is no stop.
        inside: The deepest violation of a stopping distance; None if there is
            none.
        beyond: The target is out of reach by at least this distance [m]; 0 if
            unknown.
        parked: Whether the target is out of reach only because all speeds of
            the base are limited to zero.
        no_nearer_for: Time for which the robot has come no nearer to the target
            [s].
        progress: Progress in a sequence of targets; None if there is no
            sequence.
        supervision: State of the safety supervisor; None without a supervisor.
        selection: The latest selection of a candidate by guidance; None without
            guidance.
    """

    error: PoseError
    target: Target | None = None
    effector: str = ""
    beside_line: float = math.nan
    is_there: bool = False
    hold: Hold | None = None
    stop: Hold | None = None
    inside: Hold | None = None
    beyond: float = 0.0
    parked: bool = False
    no_nearer_for: float = 0.0
    progress: TargetProgress | None = None
    supervision: SupervisorState | None = None
    selection: Selection | None = None


def describe_motion(now: Situation, robot: RobotDescription) -> MotionStatus:
    """Describes the robot's state in one sentence.

    Args:
        now: The inputs.
        robot: Description of the robot, with the display names of its links.
    """
    distance = now.error.distance
    supervision, progress = now.supervision, now.progress
    if supervision is not None and supervision.is_latched:
        return _stopped(supervision, now)
    if progress is not None and progress.failed:
        text = f"gave up: {progress.failed}"
        return MotionStatus(states.ENDED, text, distance)
    if now.progress is not None and now.progress.finished:
        return MotionStatus(states.REACHED, _reached(now.progress), distance)
    waits_for = _waits_for(supervision)
    if waits_for:
        return MotionStatus(states.WAITING, waits_for, distance)
    if not math.isfinite(distance):
        return states.NOT_STARTED
    if now.is_there and progress is not None and progress.doing:
        return MotionStatus(states.MOVING, _doing(progress), distance)
    if now.is_there:
        return MotionStatus(states.REACHED, f"at {_target(now)}", distance)
    if now.inside is not None:
        return _inside(now, now.inside, robot)
    if now.hold is None:
        text, cause = f"{_on_the_way(now)}, {_away(now)} away", ""
        if math.isfinite(now.beside_line):
            text += f", {1e3 * now.beside_line:.0f} mm beside the line"
        if now.beyond:
            text += f": {_out_of_reach(now)}"
            cause = _beyond_cause(now)
        elif now.no_nearer_for >= CIRCLING:
            text += f", no nearer for {now.no_nearer_for:.0f} s"
        return MotionStatus(
            states.MOVING, text, distance, cause, p_W=_p_WT(now, cause)
        )
    return _held(now, now.hold, robot)


def at_end(status: MotionStatus, why: str) -> MotionStatus:
    """Describes the robot's state at the end of a run.

    Args:
        status: The last `MotionStatus`.
        why: Reason why the run ended: "reached", "time limit" or "interrupted".
    """
    if why == states.REACHED:
        # Targets of other packages may end a run for other reasons.
        text = status.text if status.kind == why else states.REACHED
        return dc.replace(status, kind=states.REACHED, text=text)
    if status.kind not in (states.MOVING, states.HELD):
        return status
    text = f"{why}: {status.text}"
    return dc.replace(status, kind=states.ENDED, text=text)


def _waits_for(supervision: SupervisorState | None) -> str:
    """Returns the condition for which the start waits; empty if none."""
    if supervision is None or supervision.mode != STARTING:
        return ""
    return supervision.reason


def _stopped(supervision: SupervisorState, now: Situation) -> MotionStatus:
    reason, distance = supervision.reason, now.error.distance
    stop = now.stop or Hold(states.SUPERVISOR)
    kind, text = states.STOPPING, f"stopping: {reason}"
    if supervision.mode != STOPPING:
        if reason == UNARMED:
            return MotionStatus(states.WAITING, reason, distance)
        kind = states.STOPPED
        text = f"stopped: {reason}; waiting for an operator"
        if math.isfinite(distance):
            text += f", {_away(now)} from {_target(now)}"
        text += supervision.refusal and f"; {supervision.refusal}"
    return MotionStatus(
        kind,
        text,
        distance,
        cause=stop.cause,
        thing=stop.thing,
        link=stop.link,
        p_W=stop.p_W,
        clearance=stop.clearance,
    )


def _inside(
    now: Situation, inside: Hold, robot: RobotDescription
) -> MotionStatus:
    """Formats the state of a robot that violates a stopping distance."""
    moves, part = now.hold is None, robot.called(inside.link)
    if inside.clearance is None:
        where = f"{part} beyond {inside.thing}"
    else:
        where = f"{part} {_gap(inside.clearance)} {inside.thing}"
    text = "moving out" if moves else "no motion away from it found"
    return MotionStatus(
        states.MOVING if moves else states.HELD,
        f"{text}: {where}, {_away(now)} from {_target(now)}",
        now.error.distance,
        cause=inside.cause,
        thing=inside.thing,
        link=inside.link,
        p_W=inside.p_W,
        clearance=inside.clearance,
    )


def _held(now: Situation, hold: Hold, robot: RobotDescription) -> MotionStatus:
    way = _way(now.selection)
    part = robot.called(hold.link) if hold.link else "robot"
    text = f"{_what_holds(hold, part)}, {_away(now)} from {_target(now)}"
    cause = _cause(now, hold)
    advice = _ADVICE.get(cause, "")
    if now.beyond:
        advice = _out_of_reach(now)
    text += advice and f": {advice}"
    more = way.removesuffix(f"; {advice}")  # An action is named once.
    text += more and f"; {more}"
    return MotionStatus(
        states.HELD,
        text,
        now.error.distance,
        cause=cause,
        thing=hold.thing,
        link=hold.link,
        p_W=hold.p_W if hold.p_W is not None else _p_WT(now, cause),
        clearance=hold.clearance,
        way=way,
    )


def _cause(now: Situation, hold: Hold) -> str:
    """Returns the cause of a hold; unreachable targets take precedence."""
    if now.beyond:
        return _beyond_cause(now)
    if hold.cause != states.NOTHING:
        return hold.cause
    if now.parked:
        return states.BASE
    if now.selection is None:
        return hold.cause
    return _CAUSES_WITHOUT_PATH.get(now.selection.lack, hold.cause)


def _beyond_cause(now: Situation) -> str:
    return states.BASE if now.parked else states.NO_CONFIGURATION


def _p_WT(now: Situation, cause: str) -> np.ndarray | None:
    """Returns the target's position, if the target itself is the cause."""
    if now.target is None or cause not in _OF_THE_TARGET:
        return None
    return now.target.X_WT[:3, 3]


def _out_of_reach(now: Situation) -> str:
    if now.parked:
        return f"it is {now.beyond:.2f} m out of reach, {_ADVICE[states.BASE]}"
    return f"it is {now.beyond:.2f} m out of reach, move it nearer"


def _what_holds(hold: Hold, part: str) -> str:
    if hold.cause == states.NO_COMMAND:
        return f"braking: {hold.thing}"
    if hold.cause == states.NOT_OBEYED:
        return "robot is commanded to move and stands still"
    if hold.cause == states.NOTHING:
        return "robot stands still"
    if hold.cause == states.MOVER:
        return f"{part} waits for {hold.thing}"
    if hold.clearance is not None:
        return f"{part} held {_gap(hold.clearance)} {hold.thing}"
    if hold.cause == states.JOINT_LIMIT:
        return f"{part} held at {hold.thing}"
    return f"{part} held by {hold.thing}"


def _gap(clearance: float) -> str:
    where = "inside" if clearance < 0 else "from"
    return f"{1e3 * abs(clearance):.0f} mm {where}"


def _on_the_way(now: Situation) -> str:
    if now.progress is not None and now.progress.doing:
        return _doing(now.progress)
    target, prefix = now.target, now.effector and f"{now.effector} "
    if target is not None and target.line is not None:
        return f"{prefix}on the line to {_target(now)}"
    if target is not None and target.passed_within is not None:
        return f"{prefix}moving past {_target(now)}"
    return f"{prefix}moving to {_target(now)}"


def _doing(progress: TargetProgress) -> str:
    return (
        f"job {progress.index + 1} of {progress.count}: robot {progress.doing}"
    )


def _away(now: Situation) -> str:
    """Formats the pose error: "0.52 m", or "12 mm and 4 deg" if it is small.

    Free directions are omitted.
    """
    error, target = now.error, now.target
    if not error.distance < _NEAR:
        return f"{error.distance:.2f} m"
    place = f"{1e3 * error.distance:.0f} mm"
    angle = f"{math.degrees(error.angle):.0f} deg"
    if target is not None and not target.constrains_rotation:
        return place
    if target is not None and not target.constrains_position:
        return angle
    return f"{place} and {angle}"


def _target(now: Situation) -> str:
    if now.progress is None or now.progress.count == 1:
        return "the target"
    if now.progress.doing:
        return f"the place of job {now.progress.index + 1}"
    return f"target {now.progress.index + 1} of {now.progress.count}"


def _reached(progress: TargetProgress) -> str:
    text = "reached" if progress.count == 1 else f"reached all {progress.count}"
    if not progress.replaced:
        return text
    which = "the target" if progress.count == 1 else f"{progress.replaced}"
    return f"{text}; an operator has replaced {which}"


def _way(selection: Selection | None) -> str:
    """Returns the reason why guidance offers no other way; empty if none."""
    if selection is None:
        return ""
    if selection.missing:
        return f"guidance does not look ahead: {selection.missing}"
    if selection.unreachable:
        return selection.unreachable
    return "guidance has found no way" if selection.is_hopeless else ""
