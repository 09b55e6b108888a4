"""How the target moves by what the operator asks: a step of time at once."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.camera_mount import CameraMount
from remosplat_drake.controller.servo import pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.teleop.config import TeleopConfig
from remosplat_drake.teleop.operator_command import OperatorCommand
from remosplat_drake.teleop.scan import scan_poses
from remosplat_drake.teleop.smoothing import (
    braking_speed,
    change_velocity,
    limit_norm,
    rotated,
    rotation_to_go,
    velocity_towards,
)
from remosplat_drake.teleop.target_state import (
    FOLLOW,
    GO,
    HOLD,
    SCAN,
    VELOCITY,
    TargetState,
)

_SCAN_DISTANCE, _SCAN_ANGLE = 0.03, 0.05
"""The end effector is at a pose of a scan so near to it [m], [rad]."""


@dc.dataclass(frozen=True, eq=False)
class MotionLaw:
    """What the target's motion goes by besides the operator.

    Attributes:
        config: Its bounds, and the saved poses.
        X_WT_home: Where home is, shape (4, 4).
        dt: Length of a step [s].
        X_EC: The wrist camera (OpenCV axes) on the end effector; None
            without one, and then there is no scan.
        frames: Number of frames of a scan.
    """

    config: TeleopConfig
    X_WT_home: np.ndarray
    dt: float
    X_EC: np.ndarray | None = None
    frames: int = 8

    @staticmethod
    def make(
        config: TeleopConfig,
        robot: RobotModel,
        q0: np.ndarray,
        dt: float,
        mount: CameraMount | None = None,
        frames: int = 8,
    ) -> "MotionLaw":
        """The law of a robot whose home is where it starts.

        Args:
            config: See the attribute.
            robot: Finds the end effector.
            q0: Configuration to start from, shape (n_q,).
            dt: See the attribute.
            mount: The wrist camera; it must move with the end effector.
            frames: See the attribute.
        """
        X_WE = robot.end_effector_pose(q0)
        X_EC = None
        if mount is not None:
            X_EC = np.linalg.inv(X_WE) @ mount.pose(q0)
        return MotionLaw(config, X_WE, dt, X_EC, frames)


def advance_target(
    law: MotionLaw,
    state: TargetState,
    command: OperatorCommand,
    X_WE: np.ndarray,
    time: float,
) -> TargetState:
    """The target after one step of time.

    In the order of: what is newly wished for, what ends by itself (a dead-man
    button let go, a source in trouble, a scan's pose reached), the motion.

    Args:
        law: Bounds of the motion.
        state: The target before.
        command: All that the operator has asked for so far.
        X_WE: Measured pose of the end effector, shape (4, 4); NaN where it
            is unknown.
        time: Time now [s].
    """
    known = state.command
    state = _begin(law, dc.replace(state, command=command), known, X_WE)
    state = _end(law, state, X_WE, time)
    return _move(law, state)


def _begin(
    law: MotionLaw,
    state: TargetState,
    known: OperatorCommand,
    X_WE: np.ndarray,
) -> TargetState:
    """Takes up the newest wish, if there is a new one."""
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
        return _go(law, state, saved.matrix(), f"going to {command.pose}")
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
    """Freezes the target where the end effector is, or where itself is."""
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
        return hold(state, X_WE, "no wrist camera to scan with")
    if not np.isfinite(X_WE).all():
        return hold(state, X_WE, "no scan: the robot's pose is unknown")
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


def _end(
    law: MotionLaw, state: TargetState, X_WE: np.ndarray, time: float
) -> TargetState:
    """Ends what ends by itself, or goes on to what comes next."""
    command = state.command
    if state.mode == VELOCITY and command.V_W is None:
        return hold(state, X_WE, "hold: the dead-man button was let go")
    if state.mode == FOLLOW:
        if command.trouble:
            return hold(state, X_WE, f"hold: {command.trouble}")
        assert command.X_WT is not None
        goal = _within(law.config, command.X_WT)
        return dc.replace(state, X_WT_goal=goal)
    if state.mode == SCAN:
        return _watch_scan(law, state, X_WE, time)
    return state


def _watch_scan(
    law: MotionLaw, state: TargetState, X_WE: np.ndarray, time: float
) -> TargetState:
    """Asks for a frame where a view is reached, or is not in time."""
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
    """A pose with its position clamped into the workspace."""
    X_WT = X_WT.copy()
    X_WT[:3, 3] = np.clip(
        X_WT[:3, 3], config.workspace_lower, config.workspace_upper
    )
    return X_WT


def _move(law: MotionLaw, state: TargetState) -> TargetState:
    if state.mode == HOLD:
        return state
    config, dt = law.config, law.dt
    before, V_W = state.X_WT, _wanted_velocity(law, state)
    w_WT = change_velocity(
        state.V_WT[:3], V_W[:3], config.max_rotation_acceleration * dt
    )
    v_WT = change_velocity(
        state.V_WT[3:], V_W[3:], config.max_acceleration * dt
    )
    X_WT = np.eye(4)
    X_WT[:3, :3] = rotated(before[:3, :3], w_WT * dt)
    # A change of mind close to the edge may come too late to brake: there
    # the workspace comes before the bound on the acceleration. A target that
    # began outside, where the end effector was, may only come in.
    p_WT = before[:3, 3]
    X_WT[:3, 3] = np.clip(
        p_WT + v_WT * dt,
        np.minimum(config.workspace_lower, p_WT),
        np.maximum(config.workspace_upper, p_WT),
    )
    v_WT = (X_WT[:3, 3] - p_WT) / dt
    goal = X_WT if state.mode == VELOCITY else state.X_WT_goal
    V_WT = np.concatenate([w_WT, v_WT])
    return dc.replace(state, X_WT=X_WT, V_WT=V_WT, X_WT_goal=goal)


def _wanted_velocity(law: MotionLaw, state: TargetState) -> np.ndarray:
    """Where the target wants to move, within its speeds; V_W, (6,)."""
    config, dt = law.config, law.dt
    if state.mode == VELOCITY:
        assert state.command.V_W is not None
        w_W = limit_norm(state.command.V_W[:3], config.max_rotation)
        v_W = limit_norm(state.command.V_W[3:], config.max_speed)
        return np.concatenate([w_W, _along_walls(law, state.X_WT, v_W)])
    goal, R_WT = state.X_WT_goal, state.X_WT[:3, :3]
    turn = rotation_to_go(
        R_WT, goal[:3, :3], state.V_WT[:3], config.max_rotation_acceleration
    )
    w_W = velocity_towards(
        turn, config.max_rotation, config.max_rotation_acceleration, dt
    )
    offset = goal[:3, 3] - state.X_WT[:3, 3]
    v_W = velocity_towards(
        offset, config.max_speed, config.max_acceleration, dt
    )
    return np.concatenate([w_W, v_W])


def _along_walls(
    law: MotionLaw, X_WT: np.ndarray, v_W: np.ndarray
) -> np.ndarray:
    """A velocity that can still be braked at the walls of the workspace."""
    config, p_WT = law.config, X_WT[:3, 3]
    # What three axes brake with together must not exceed the whole.
    share = config.max_acceleration / np.sqrt(3.0)
    back = [
        braking_speed(max(room, 0.0), share, law.dt)
        for room in p_WT - config.workspace_lower
    ]
    ahead = [
        braking_speed(max(room, 0.0), share, law.dt)
        for room in config.workspace_upper - p_WT
    ]
    return np.clip(v_W, np.negative(back), ahead)
