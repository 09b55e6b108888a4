"""`advance_task`: advances a task by one tick, as a pure function.

A step lasts until its end effector is at the goal and its hand has the
commanded width. Then the arm comes to a standstill, and the next step begins.
Contact rules and payload change only at a standstill, and only if the distances
there allow it. A step that takes too long fails: the robot executes the steps
that undo it, and tries the next alternative of the block (a job of the task).
If no alternative is left, the task has failed.
"""

import dataclasses as dc
import math
from collections.abc import Mapping

import numpy as np

from remosplat_drake.robot import planar_pose
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.hand_reading import HandReading
from remosplat_drake.signals.target import Target
from remosplat_drake.task.carrying import make_payload
from remosplat_drake.task.step import (
    AT,
    ATTACH,
    BASE_TO,
    BY_HAND,
    BY_WORLD,
    OBJECT_TO,
    ON_OBJECT,
    RELEASE,
    Goal,
    Step,
)
from remosplat_drake.task.task import DONE, FAILED, RUNNING, Task, TaskState

WIDTH = 0.001
"""A hand has reached its commanded width if the measured width differs by less
than this [m]."""

AT_REST = 0.02
"""An axis counts as at rest if its measured speed is below this [m/s,
rad/s]."""

_AROUND = 0.03
"""A hand can hold an object only if the end effector is at most this far from
the object's box [m]."""


@dc.dataclass(frozen=True, eq=False)
class Observation:
    """The measurements of a robot at a tick.

    Attributes:
        time: Time of the tick [s].
        q: The measured configuration, shape (n_q,) [rad, m].
        v: The measured velocity of the axes, shape (n_u,) [rad/s, m/s].
        u: The command that the robot executes, shape (n_u,) [rad/s, m/s].
        hands: The measurements of the robot's hands, keyed by end effector.
    """

    time: float
    q: np.ndarray
    v: np.ndarray
    u: np.ndarray
    hands: Mapping[int, HandReading] = dc.field(default_factory=dict)

    @property
    def stands_still(self) -> bool:
        """Whether the command is zero, and the robot is at rest."""
        return not self.u.any() and bool(np.abs(self.v).max() < AT_REST)


def advance_task(task: Task, state: TaskState, now: Observation) -> TaskState:
    """Advances a task by one tick.

    Args:
        task: The task.
        state: The state of the task at the previous tick.
        now: The measurements of the robot.

    Returns:
        The state of the task; the same object if nothing has changed.
    """
    if state.outcome != RUNNING or not np.isfinite(now.q).all():
        return state
    lost = loss(state, now)
    if lost:
        failures = (*state.failures, lost)
        return dc.replace(state, failures=failures, outcome=FAILED)
    if not state.begun:
        may_begin = now.time > state.since and now.stands_still
        return _begun(task, state, now) if may_begin else state
    step = state.present(task)
    if _is_done(task, state, step, now):
        return _next(task, dc.replace(state, begun=False, since=now.time))
    if now.time - state.since > step.patience:
        reason = f"{step.text}: not finished within {step.patience:g} s"
        if step.goal is not None:
            error = error_to(task, state, step, now.q)
            reason += f", {1e3 * error.distance:.0f} mm and"
            reason += f" {math.degrees(error.angle):.0f} deg away"
        return _failed(task, state, now, reason)
    return state


def error_to(
    task: Task, state: TaskState, step: Step, q: np.ndarray
) -> PoseError:
    """Returns the pose error of the end effector or base that a step moves.

    Args:
        task: The task.
        state: The progress of the task.
        step: The present step.
        q: The configuration, shape (n_q,) [rad, m].
    """
    X_W = _moved(task.robot, step, q)
    return Target(X_W if state.X_WT is None else state.X_WT).error(X_W)


def _moved(robot: RobotModel, step: Step, q: np.ndarray) -> np.ndarray:
    """Pose in W of the end effector or base that the step moves, (4, 4)."""
    if step.drives:
        return planar_pose.matrix(q[:3])
    return robot.end_effector_poses(q)[step.effector]


def _begun(task: Task, state: TaskState, now: Observation) -> TaskState:
    """Begins the present step if the distances at q allow it."""
    step, X_WE = state.present(task), task.robot.end_effector_poses(now.q)
    state = with_held_object(state, X_WE)
    changed = dc.replace(state, begun=True, since=now.time, q_A=now.q)
    if step.action == ATTACH:
        reason = _off_the_hand(state, step, now, X_WE)
        if reason:
            return _failed(task, state, now, reason)
        changed = _attached(task, changed, step, now, X_WE)
    elif step.action == RELEASE:
        if not state.held or step.effector != state.holder:
            reason = f"{step.text}: the hand does not hold an object"
            return _failed(task, state, now, reason)
        changed = changed.emptied
    if changed.payload is not None:
        holders = _holders(task.robot, changed, step)
        payload = dc.replace(changed.payload, holders=holders)
        changed = dc.replace(changed, payload=payload)
    if step.width is not None:
        told = {**state.told, step.effector: (step.width, step.force)}
        changed = dc.replace(changed, told=told)
    X_WT = _moved(task.robot, step, now.q)
    if step.goal is not None:
        X_WT = _place_of(state, step.goal, X_WT)
    changed = dc.replace(changed, X_WT=X_WT, rules=step.rules)
    reason = task.permission(state, changed, now.q)
    if reason:
        return _failed(task, state, now, f"{step.text}: {reason}")
    return changed


def with_held_object(state: TaskState, X_WE: np.ndarray) -> TaskState:
    """Returns the state with the present pose of the carried object.

    Args:
        state: The state of the task.
        X_WE: The poses of the end effectors, shape (n, 4, 4).
    """
    if state.X_OE is None:
        return state
    X_WO = X_WE[state.holder] @ np.linalg.inv(state.X_OE)
    return dc.replace(state, objects=state.moved(state.held, X_WO))


def _attached(
    task: Task,
    state: TaskState,
    step: Step,
    now: Observation,
    X_WE: np.ndarray,
) -> TaskState:
    """Returns the state after the step's end effector has taken the object."""
    thing, spheres = state.named(step.object), task.spheres[step.object]
    payload = make_payload(task.robot, thing, spheres, now.q, step.effector)
    X_WO = thing.X_WO.GetAsMatrix4()
    hand = now.hands.get(step.effector)
    return dc.replace(
        state,
        payload=payload,
        holder=step.effector,
        giver=state.holder if state.held else None,
        # The pads are compliant, so the measured width is the reference with
        # which the task later detects that the object slips.
        grip=None if step.grip is None or hand is None else hand.width,
        X_OE=np.linalg.solve(X_WO, X_WE[step.effector]),
    )


def _holders(robot: RobotModel, state: TaskState, step: Step) -> frozenset[str]:
    """The links that may touch the carried object during a step."""
    holders = hand_links(robot, state.holder)
    if state.giver is not None:
        holders |= hand_links(robot, state.giver)
    for rule in step.rules:
        if rule.object == state.held:
            holders |= rule.links
    return holders


def _place_of(state: TaskState, goal: Goal, X_WE: np.ndarray) -> np.ndarray:
    """Converts a goal to the pose X_WT, shape (4, 4)."""
    if goal.kind == ON_OBJECT:
        return state.named(goal.object).X_WO.GetAsMatrix4() @ goal.X
    if goal.kind == OBJECT_TO:
        X_OE = np.eye(4) if state.X_OE is None else state.X_OE
        return goal.X @ X_OE
    if goal.kind == BY_WORLD:
        return goal.X @ X_WE
    if goal.kind == BY_HAND:
        return X_WE @ goal.X
    assert goal.kind in (AT, BASE_TO)
    return goal.X


def _is_done(
    task: Task, state: TaskState, step: Step, now: Observation
) -> bool:
    if step.goal is not None:
        errors = [error_to(task, state, step, now.q)]
        if step.drives:
            errors += _arm_errors(task.robot, state, now.q)
        if any(e.distance >= step.position for e in errors):
            return False
        if any(e.angle >= step.angle for e in errors):
            return False
    hand = now.hands.get(step.effector)
    if step.width is None or hand is None:
        return True
    is_there = abs(hand.width - step.width) < WIDTH
    # A hand that closes on an object stops before the commanded width.
    is_late = now.time - state.since > 0.5
    return is_there or (is_late and hand.at_rest)


def _arm_errors(
    robot: RobotModel, state: TaskState, q: np.ndarray
) -> list[PoseError]:
    """Errors of the end effectors' poses in the base since the step began."""
    assert state.q_A is not None
    X_BE = [
        np.linalg.inv(planar_pose.matrix(x[:3])) @ robot.end_effector_poses(x)
        for x in (q, state.q_A)
    ]
    return [Target(shall).error(now) for now, shall in zip(*X_BE, strict=True)]


def _next(task: Task, state: TaskState) -> TaskState:
    """Continues with the next step, the next block or the next alternative."""
    done = state.present(task)
    if done.goal is not None and done.effector == state.giver:
        state = dc.replace(state, giver=None)
    if state.undoing:
        state = dc.replace(state, undoing=state.undoing[1:])
        return state if state.undoing else _next_way(task, state)
    steps = task.blocks[state.block].ways[state.way]
    if state.step + 1 < len(steps):
        return dc.replace(state, step=state.step + 1)
    if state.block + 1 < len(task.blocks):
        load, block = state.load, state.block + 1
        return dc.replace(state, block=block, way=0, step=0, carried=load)
    return dc.replace(state, outcome=DONE)


def _failed(
    task: Task, state: TaskState, now: Observation, reason: str
) -> TaskState:
    """Undoes the present step, and then tries the next alternative."""
    failures = (*state.failures, reason)
    undo = () if state.undoing else state.present(task).undo
    is_lost = bool(state.undoing) and not undo
    state = dc.replace(
        state, failures=failures, undoing=undo, begun=False, since=now.time
    )
    if is_lost:
        return dc.replace(state, outcome=FAILED)
    return state if undo else _next_way(task, state)


def _next_way(task: Task, state: TaskState) -> TaskState:
    """Tries the next alternative if the load is the same as when it began."""
    is_left = state.way + 1 < len(task.blocks[state.block].ways)
    if is_left and state.load == state.carried:
        return dc.replace(state, way=state.way + 1, step=0)
    return dc.replace(state, outcome=FAILED)


def loss(state: TaskState, now: Observation) -> str:
    """Returns the reason why the carried object may be lost; "" if it is held.

    Args:
        state: The state of the task.
        now: The measurements of the robot.
    """
    hand, name = now.hands.get(state.holder), state.held
    if not name or hand is None:
        return ""
    if not hand.is_known:
        return f"the hand's width is unknown while it holds the {name}"
    if has_slipped(state, now):
        return f"the {name} has slipped out of the hand"
    return ""


def has_slipped(state: TaskState, now: Observation) -> bool:
    """Returns whether the hand's width shows that the object has slipped out.

    Args:
        state: The state of the task.
        now: The measurements of the robot.
    """
    hand = now.hands.get(state.holder)
    if hand is None or state.grip is None or not hand.is_known:
        return False
    return hand.has_let_go(state.grip)


def _off_the_hand(
    state: TaskState, step: Step, now: Observation, X_WE: np.ndarray
) -> str:
    """Returns the reason why an object is not in a hand; "" if it is."""
    is_given = state.held == step.object and step.effector != state.holder
    if state.held and not is_given:
        return f"{step.text}: the hand holds the {state.held}"
    hand = now.hands.get(step.effector)
    if hand and step.grip is not None and hand.is_narrower(step.grip):
        return f"{step.text}: the hand has closed without an object"
    thing = state.named(step.object)
    p_OE = thing.X_WO.inverse().multiply(X_WE[step.effector, :3, 3])
    lower, upper = thing.corners
    off = np.linalg.norm(np.maximum(np.maximum(lower - p_OE, p_OE - upper), 0))
    if off > _AROUND:
        return (
            f"{step.text}: the {step.object} is {1e3 * off:.0f} mm away from"
            " the hand"
        )
    return ""
