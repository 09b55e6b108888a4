"""`Rollout`: the closed loop simulated ahead on the known map."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick import run_tick
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import RobotState
from remosplat_drake.signals.distance_field import DistanceField

RUNNING, REACHED, STALLED, HORIZON = "running", "reached", "stalled", "horizon"

_STALL_SPEED = 0.012
"""Below this speed nothing moves any more: max(|v|, |q_dot| / 2)."""

_STALL_TIME = 0.5
"""A rollout that has stood still for so long has stalled [s]."""


@dc.dataclass(frozen=True, eq=False)
class Rollout:
    """A simulated future, advanced one step at a time.

    Attributes:
        guidance: The candidate that is tried.
        q: Configuration reached so far, shape (n_q,).
        u: Command being executed there, shape (n_u,).
        time: Simulated time since the start [s].
        still: For how long it has stood still [s].
        status: RUNNING, REACHED, STALLED or HORIZON.
        position_error: Distance to the target [m].
        angle_error: Angle to the target [rad].
        path: End-effector positions so far, a tuple of arrays of shape (3,).
        state: Kinematics at q while it is running; they spare the next step
            from computing them again.
    """

    guidance: Guidance
    q: np.ndarray
    u: np.ndarray
    time: float = 0.0
    still: float = 0.0
    status: str = RUNNING
    position_error: float = math.inf
    angle_error: float = math.inf
    path: tuple[np.ndarray, ...] = ()
    state: RobotState | None = None

    def __deepcopy__(self, memo) -> "Rollout":
        return self

    def score(self, first_tier: float) -> float:
        """Its price in seconds, lower is better.

        Time to the target, plus 4 s for every 10 mm of stopping distance
        given up; what does not arrive costs 58 and more.
        """
        stopping = self.guidance.stopping
        given_up = 0.0 if stopping is None else first_tier - stopping
        if self.status == REACHED:
            return self.time + 400.0 * given_up
        return 58.0 + 10.0 * self.position_error + self.angle_error


def step_rollout(
    law: ReactiveLaw,
    rollout: Rollout,
    field: DistanceField,
    X_WT: np.ndarray,
    arrived,
    horizon: float,
) -> Rollout:
    """One step further, by the very tick that drives the robot.

    Args:
        law: The control law with the rollout's own step as its period.
        rollout: Where it stands.
        field: The map.
        X_WT: Target pose, shape (4, 4).
        arrived: Whether a `PoseError` counts as arrival.
        horizon: Longest simulated time [s].
    """
    state = rollout.state or law.robot.state(rollout.q)
    report = run_tick(
        law,
        rollout.time,
        rollout.q,
        X_WT,
        field.clearances(state.spheres, law.collision.influence),
        field,
        rollout.u,
        rollout.guidance,
        state,
    )
    q = law.robot.advance(rollout.q, report.command, law.dt)
    following = law.robot.state(q)
    error = pose_error(following.X_WE, X_WT)
    time = rollout.time + law.dt
    still = rollout.still + law.dt if _stands(law, report.command) else 0.0
    if arrived(error):
        status = REACHED
    elif still >= _STALL_TIME - 1e-9:
        status = STALLED
    elif time >= horizon - 1e-9:
        status = HORIZON
    else:
        status = RUNNING
    return Rollout(
        rollout.guidance,
        q,
        report.command,
        time,
        still,
        status,
        error.distance,
        error.angle,
        (*rollout.path, following.X_WE[:3, 3]),
        following if status == RUNNING else None,
    )


def _stands(law: ReactiveLaw, u: np.ndarray) -> bool:
    base = np.abs(u[: min(law.robot.n_base, 1)]).max(initial=0.0)
    arm = np.abs(u[law.robot.n_base :]).max(initial=0.0)
    return max(base, 0.5 * arm) < _STALL_SPEED
