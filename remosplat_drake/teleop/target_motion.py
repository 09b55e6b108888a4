"""Moves a target as an operator requests: hold, follow, go, scan."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.target_state import (
    FOLLOW,
    GO,
    HOLD,
    SCAN,
    VELOCITY,
    TargetState,
)
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.scan import scan_poses
from remosplat_drake.teleop.target_step import move
from remosplat_drake.teleop.teleop_config import TeleopConfig

_SCAN_DISTANCE, _SCAN_ANGLE = 0.03, 0.05
"""The end effector has reached a pose of a scan if its errors are smaller than
these [m], [rad]."""


def advance_target(
    law: MotionLaw,
    state: TargetState,
    command: OperatorCommand,
    X_WE: np.ndarray,
    time: float,
) -> TargetState:
    """Advances the target by one step of time.

    The function first applies new requests. Then it ends a motion if the
    dead-man switch is released, if the source of requests reports a problem, or
    if a pose of a scan is reached. Finally, it moves the target.

    Args:
        law: Bounds and settings of the motion.
        state: The previous target.
        command: All requests of the operators so far.
        X_WE: Measured pose of the end effector, shape (4, 4); NaN where it
            is unknown.
        time: Time now [s].
    """
    before = state
    state = dc.replace(state, command=command)
    state = _begin(law, state, before.command, X_WE)
    state = _break_off(before, state)
    state = _end(law, state, X_WE, time)
    return move(law, state, X_WE)


def stand(
    state: TargetState,
    command: OperatorCommand,
    X_WE: np.ndarray,
    text: str,
) -> TargetState:
    """Keeps the target at the hand while a job or a stop has control.

    Requests in the meantime are ignored.

    Args:
        state: The previous target.
        command: All requests of the operators so far.
        X_WE: Measured pose of the end effector, shape (4, 4); NaN where it
            is unknown.
        text: Reason, for display to the operator.
    """
    now = dc.replace(state, command=command)
    return _break_off(state, hold(now, X_WE, text))


def _begin(
    law: MotionLaw,
    state: TargetState,
    known: OperatorCommand,
    X_WE: np.ndarray,
) -> TargetState:
    """Starts the newest request, if there is a new request."""
    command = state.command
    if command.holds > known.holds:
        return hold(state, X_WE, "hold")
    if command.homes > known.homes:
        return _go(law, state, law.X_WT_home, "going home")
    if command.poses > known.poses:
        saved = law.config.poses.get(command.pose)
        if saved is None:
            text = f"no saved pose {command.pose!r}"
            return hold(state, X_WE, text)
        return _go(law, state, saved.matrix(), f"going to {command.pose!r}")
    if command.scans > known.scans:
        return _begin_scan(law, state, X_WE)
    if command.V_W is not None and known.V_W is None:
        return dc.replace(
            state, mode=VELOCITY, text=f"led by the {command.source}"
        )
    if command.moves > known.moves and command.X_WT is not None:
        return dc.replace(
            state, mode=FOLLOW, text=f"following the {command.source}"
        )
    return state


def hold(state: TargetState, X_WE: np.ndarray, text: str) -> TargetState:
    """Holds the target at the end effector's present pose.

    Args:
        state: The previous target.
        X_WE: Measured pose of the end effector, shape (4, 4); NaN if it is
            unknown. The target then keeps its own pose.
        text: Reason, for display to the operator.
    """
    X_WT = X_WE if np.isfinite(X_WE).all() else state.X_WT
    return dc.replace(
        state,
        mode=HOLD,
        X_WT=X_WT,
        V_WT=np.zeros(6),
        X_WT_goal=X_WT,
        text=text,
        scan=(),
    )


def _go(
    law: MotionLaw, state: TargetState, X_WT: np.ndarray, text: str
) -> TargetState:
    return dc.replace(
        state, mode=GO, X_WT_goal=_within(law.config, X_WT), text=text
    )


def _begin_scan(
    law: MotionLaw, state: TargetState, X_WE: np.ndarray
) -> TargetState:
    if law.X_EC is None:
        return hold(state, X_WE, "no scan: the robot has no wrist camera")
    if not np.isfinite(X_WE).all():
        return hold(state, X_WE, "no scan: the robot's pose is unknown")
    # A scan has no free directions. In directions that were free before, the
    # target therefore begins at the hand's present pose.
    target = law.target(state)
    if target.free:
        state = dc.replace(state, X_WT=target.nearest_pose(X_WE))
    poses = scan_poses(X_WE, law.X_EC, law.frames, law.config.scan)
    return _next_view(law, state, poses, len(poses))


def _next_view(
    law: MotionLaw,
    state: TargetState,
    poses: tuple[np.ndarray, ...],
    size: int,
) -> TargetState:
    number = size - len(poses) + 1
    return dc.replace(
        state,
        mode=SCAN,
        X_WT_goal=_within(law.config, poses[0]),
        text=f"scan: view {number} of {size}",
        scan=poses,
        scan_size=size,
        shown=None,
        arrived=None,
    )


def _break_off(before: TargetState, state: TargetState) -> TargetState:
    """Marks the latest frame of a broken-off scan as the scan's last frame."""
    broken_off = before.mode == SCAN and state.mode != SCAN
    if broken_off and before.scan_size > len(before.scan):
        return dc.replace(state, unfinished=state.unfinished - 1)
    return state


def _end(
    law: MotionLaw, state: TargetState, X_WE: np.ndarray, time: float
) -> TargetState:
    """Ends a finished motion, or sets its next goal."""
    command = state.command
    if state.mode == VELOCITY and command.V_W is None:
        why = command.trouble or "the dead-man button was released"
        return hold(state, X_WE, f"hold: {why}")
    if state.mode == FOLLOW and command.trouble:
        return hold(state, X_WE, f"hold: {command.trouble}")
    if state.mode == FOLLOW and command.X_WT is not None:
        goal = _within(law.config, command.X_WT)
        return dc.replace(state, X_WT_goal=goal)
    if state.mode == SCAN:
        return _watch_scan(law, state, X_WE, time)
    return state


def _watch_scan(
    law: MotionLaw, state: TargetState, X_WE: np.ndarray, time: float
) -> TargetState:
    """Requests a frame of a view when the hand is there, or at its timeout."""
    config = law.config.scan
    if state.shown is None and _is_at(state.X_WT, state.X_WT_goal):
        state = dc.replace(state, shown=time)
    if state.arrived is None and _is_at(X_WE, state.X_WT_goal):
        state = dc.replace(state, arrived=time)
    dwelt = _has_passed(config.dwell, state.arrived, time)
    if not dwelt and not _has_passed(config.timeout, state.shown, time):
        return state
    state = dc.replace(state, frames_wanted=state.frames_wanted + 1)
    if len(state.scan) == 1:
        return hold(state, X_WE, "scan done")
    state = dc.replace(state, unfinished=state.unfinished + 1)
    return _next_view(law, state, state.scan[1:], state.scan_size)


def _has_passed(duration: float, since: float | None, time: float) -> bool:
    return since is not None and time - since >= duration


def _is_at(X_WE: np.ndarray, X_WT: np.ndarray) -> bool:
    error = pose_error(X_WE, X_WT)
    return error.distance < _SCAN_DISTANCE and error.angle < _SCAN_ANGLE


def _within(config: TeleopConfig, X_WT: np.ndarray) -> np.ndarray:
    """Returns a pose whose position is clamped to the workspace."""
    X_WT = X_WT.copy()
    X_WT[:3, 3] = np.clip(
        X_WT[:3, 3], config.workspace_lower, config.workspace_upper
    )
    return X_WT
