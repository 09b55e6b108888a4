"""Computes metrics of motion, some of which the paper defines (section V).

The functions take a trajectory: configurations q, shape (T + 1, n_q), at the
control ticks and at the end, and commands u, shape (T, n_u), between these.
"""

import numpy as np

from remosplat_drake.robot.pose_error import PoseError, pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.arrival import ArrivalConfig, has_arrived

RESAMPLING_PERIOD = 0.05
"""Sampling period of `resampled_acceleration` [s]."""

FAR = 0.1
"""Upper limit of the measured distance of the robot from itself [m]; larger
distances are reported as this value."""

JACOBIAN_STEP = 1e-5
"""Half of the time step of the finite differences of a Jacobian [s]."""


def target_errors(
    robot: RobotModel, q: np.ndarray, X_WTs: np.ndarray
) -> list[PoseError]:
    """Returns the largest error of any end effector at each configuration.

    Args:
        robot: The robot.
        q: Configurations, shape (T + 1, n_q).
        X_WTs: Target poses of the robot's first end effectors, shape
            (e, 4, 4).
    """
    errors = []
    for q_t in q:
        found = [
            pose_error(X_WE, X_WT)
            for X_WE, X_WT in zip(
                robot.end_effector_poses(q_t), X_WTs, strict=False
            )
        ]
        errors.append(_worst(found))
    return errors


def _worst(errors: list[PoseError]) -> PoseError:
    """Returns the largest distance, angle and L1 norm of several errors."""
    return PoseError(
        max(errors, key=lambda error: error.distance).p_ET_W,
        max(errors, key=lambda error: error.angle).rotation_W,
        max(errors, key=lambda error: error.distance_l1).p_ET_E,
    )


def arrival_tick(errors: list[PoseError], rule: ArrivalConfig) -> int | None:
    """Returns the index of the first configuration that counts as arrived.

    Args:
        errors: Pose error at each configuration, in order.
        rule: Tolerances and success rule.

    Returns:
        The index; None if no configuration counts.
    """
    arrived = (i for i, e in enumerate(errors) if has_arrived(e, rule))
    return next(arrived, None)


def minimum_clearances(
    robot: RobotModel, q: np.ndarray, truth: DistanceField
) -> np.ndarray:
    """Returns the robot's smallest true clearance at each q, (T + 1,) [m]."""
    return np.array(
        [truth.clearances(robot.spheres_at(q_t)).minimum() for q_t in q]
    )


def self_distance(robot: RobotModel, q: np.ndarray) -> float | None:
    """Returns the smallest distance of the robot from itself, up to `FAR` [m].

    It is the smallest distance between the convex hulls of two links. It
    includes all pairs of links that the robot keeps apart and that do not
    overlap in the home posture.

    Args:
        robot: The robot.
        q: Configurations, shape (T + 1, n_q).

    Returns:
        The distance, negative if links overlap; None if the robot keeps no pair
        of links apart.
    """
    pairs = self_collision_pairs(robot, 0.0)
    apart = pairs.allowance == 0.0
    if not apart.any():
        return None
    found = [pairs.distances(q_t, FAR)[apart] for q_t in q]
    return float(np.min(found))


def between_ticks(q: np.ndarray, parts: int) -> np.ndarray:
    """Interpolates configurations that divide each tick into equal parts.

    Args:
        q: Configurations at the control ticks, shape (T + 1, n_q).
        parts: Number of equal parts of a tick.

    Returns:
        The interpolated configurations, without those at the ticks, shape (T,
        parts - 1, n_q).
    """
    fractions = np.arange(1, parts)[:, None] / parts
    return q[:-1, None] + fractions * np.diff(q, axis=0)[:, None]


def end_effector_positions(robot: RobotModel, q: np.ndarray) -> np.ndarray:
    """Returns the end effector's positions p_WE, shape (T + 1, 3) [m]."""
    return np.array([robot.end_effector_pose(q_t)[:3, 3] for q_t in q])


def mean_acceleration(
    robot: RobotModel, q: np.ndarray, u: np.ndarray, dt: float
) -> float:
    """Returns the paper's gracefulness: the end effector's mean |a| [m/s^2].

    a = J du/dt + dJ/dt u, where du/dt is the central difference of the commands
    at the control rate (one-sided at both ends). |a| is averaged over the ticks
    (paper section V, "Gracefulness"; as defined in the authors' code). This
    metric has two defects: it does not include the acceleration at start and
    stop, and it grows with the control rate. `resampled_acceleration` has
    neither defect.

    Args:
        robot: Model of the robot, for its Jacobians.
        q: Configurations at the control ticks, shape (T, n_q) or (T + 1, n_q).
        u: Commands between the ticks, shape (T, n_u).
        dt: Control period [s].

    Returns:
        The mean; 0 for fewer than two ticks.
    """
    if len(u) < 2:
        return 0.0
    du = np.gradient(u, dt, axis=0)
    total = 0.0
    for q_t, u_t, du_t in zip(q, u, du, strict=False):
        J = robot.state(q_t).Jv_WE
        ahead, behind = (
            robot.state(robot.advance(q_t, u_t, h)).Jv_WE
            for h in (JACOBIAN_STEP, -JACOBIAN_STEP)
        )
        dJ = (ahead - behind) / (2 * JACOBIAN_STEP)
        total += float(np.linalg.norm(J @ du_t + dJ @ u_t))
    return total / len(u)


def jerk_share(robot: RobotModel, u: np.ndarray, dt: float) -> float | None:
    """Returns the largest jerk, relative to the arm's limits.

    The jerk is the second difference of the commands, divided by dt^2; before
    the first command, the robot is at rest.

    Args:
        robot: Model of the robot, for its limits.
        u: Commands between the ticks, shape (T, n_u).
        dt: Control period [s].

    Returns:
        The ratio; None if the robot's description states no limits.
    """
    if not np.isfinite(robot.jerk_limit).any():
        return None
    jerk = np.diff(u, n=2, axis=0, prepend=np.zeros((2, u.shape[1]))) / dt**2
    return float((np.abs(jerk) / robot.jerk_limit).max(initial=0.0))


def torque_share(
    robot: RobotModel, q: np.ndarray, u: np.ndarray, dt: float
) -> float | None:
    """Returns the largest torque of the arm, relative to its motors' limits.

    The torques that the commands require are computed by inverse dynamics, with
    the masses of the model file and an empty hand; see `ArmDynamics`.

    Args:
        robot: Model of the robot.
        q: Configurations at the ticks, shape (T, n_q) or (T + 1, n_q).
        u: Commands between the ticks, shape (T, n_u).
        dt: Control period [s].

    Returns:
        The ratio; None if the model file states no limits.
    """
    dynamics = robot.dynamics
    if not np.isfinite(dynamics.limit).any():
        return None
    q = q[: len(u)]
    pairs = zip(q, u, strict=True)
    v = np.array([robot.velocity_map(q_t) @ u_t for q_t, u_t in pairs])
    v = v.reshape(-1, robot.n_q)
    a = np.diff(v, axis=0, prepend=np.zeros((1, robot.n_q))) / dt
    torques = np.abs(dynamics.torques(q, v[:, None], a[:, None]))
    return float((torques / dynamics.limit).max(initial=0.0))


def resampled_acceleration(
    p_WE: np.ndarray, dt: float, period: float = RESAMPLING_PERIOD
) -> float:
    """Returns the end effector's mean |a| from rest to rest [m/s^2].

    Positions are resampled to a fixed period, so that the result hardly depends
    on the control rate. Zero velocities are added at both ends, so that
    starting and stopping count, too.

    Args:
        p_WE: Positions of the end effector in W at intervals of dt, shape (T +
            1, 3) [m].
        dt: Period of the positions [s].
        period: Period to which the positions are resampled [s].

    Returns:
        The mean; 0 if the motion is shorter than one period.
    """
    end = (len(p_WE) - 1) * dt
    # Because of the small constant, rounding does not omit the last sample.
    wanted = period * np.arange(np.floor(end / period + 1e-9) + 1)
    if len(wanted) < 2:
        return 0.0
    times = dt * np.arange(len(p_WE))
    p = np.stack([np.interp(wanted, times, x) for x in p_WE.T], axis=1)
    v = np.diff(p, axis=0) / period
    rest = np.zeros((1, 3))
    dv = np.diff(np.concatenate([rest, v, rest]), axis=0)
    return float(np.linalg.norm(dv, axis=1).mean() / period)


def is_stalled(
    robot: RobotModel, q: np.ndarray, dt: float, window: float, reach: float
) -> bool:
    """Returns whether end effector and base were almost at rest at the end.

    Args:
        robot: Model of the robot, for its kinematics.
        q: Configurations at the control ticks, shape (T + 1, n_q).
        dt: Control period [s].
        window: Length of the evaluated time before the end [s].
        reach: A point counts as at rest if its path in this time is at most
            this long [m].
    """
    last = q[-1 - round(window / dt) :]
    if len(last) < 2:
        return False
    paths = [end_effector_positions(robot, last)]
    if robot.n_base:
        paths.append(last[:, :2])
    return all(
        np.linalg.norm(np.diff(p, axis=0), axis=1).sum() < reach for p in paths
    )
