"""Moves the target by one step: to its goal, or as a gamepad requests."""

import dataclasses as dc

import numpy as np

from remosplat_drake.signals.target_state import HOLD, VELOCITY, TargetState
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.smoothing import (
    braking_speed,
    change_velocity,
    limit_norm,
    rotated,
    rotation_to_go,
    velocity_towards,
)


def move(law: MotionLaw, state: TargetState, X_WE: np.ndarray) -> TargetState:
    """Moves the target by one time step; a held target does not move.

    Args:
        law: Bounds of the motion.
        state: The target with its mode and its goal.
        X_WE: Measured pose of the end effector, shape (4, 4).
    """
    if state.mode == HOLD:
        return state
    config, dt = law.config, law.dt
    before, V_W = state.X_WT, _wanted_velocity(law, state, X_WE)
    w_WT = change_velocity(
        state.V_WT[:3], V_W[:3], config.max_rotation_acceleration * dt
    )
    v_WT = change_velocity(
        state.V_WT[3:], V_W[3:], config.max_acceleration * dt
    )
    X_WT = np.eye(4)
    X_WT[:3, :3] = rotated(before[:3, :3], w_WT * dt)
    # If the goal changes close to the edge of the workspace, the bounded
    # acceleration may be too small to brake before the edge. Then the workspace
    # has priority. A target that began at an end effector outside the workspace
    # may only move inward.
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


def _wanted_velocity(
    law: MotionLaw, state: TargetState, X_WE: np.ndarray
) -> np.ndarray:
    """Returns the target's desired velocity V_W within its limits, (6,)."""
    config, dt = law.config, law.dt
    if state.mode == VELOCITY:
        assert state.command.V_W is not None
        w_W = limit_norm(state.command.V_W[:3], config.max_rotation)
        v_W = limit_norm(state.command.V_W[3:], config.max_speed)
        v_W = _limited(law, state.X_WT, X_WE, v_W)
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


def _limited(
    law: MotionLaw, X_WT: np.ndarray, X_WE: np.ndarray, v_W: np.ndarray
) -> np.ndarray:
    """Bounds a velocity so that the target is at most `max_lead` ahead."""
    config, lead = law.config, X_WT[:3, 3] - X_WE[:3, 3]
    length = float(np.linalg.norm(lead))
    if not length > 0.0:
        return v_W
    away, room = v_W @ lead / length, config.gamepad.max_lead - length
    speed = braking_speed(max(room, 0.0), config.max_acceleration, law.dt)
    return v_W if away <= speed else v_W - lead * ((away - speed) / length)


def _along_walls(
    law: MotionLaw, X_WT: np.ndarray, v_W: np.ndarray
) -> np.ndarray:
    """Bounds a velocity so that the target can brake in the workspace."""
    config, p_WT = law.config, X_WT[:3, 3]
    # The braking decelerations of the three axes together must not exceed the
    # bound.
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
