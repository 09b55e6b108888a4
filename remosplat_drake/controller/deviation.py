"""Compares the desired and the executed velocity of an end effector."""

import numpy as np

from remosplat_drake.controller.program.servo import target_twist
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.tick_report import TickReport


def end_effector_velocities(
    report: TickReport,
    executed: np.ndarray,
    robot: RobotModel,
    gain: float,
    max_speed: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the desired and the executed velocity of E (paper figure 5).

    E is the first end effector that has a target.

    Args:
        report: The report of a tick. Before the first tick, both velocities are
            NaN.
        executed: The command u that the station executes, shape (n_u,). With a
            supervisor, it is the supervisor's output.
        robot: The robot, for its kinematics.
        gain: The servo's proportional gain beta [1/s].
        max_speed: The servo's bound on the translational speed [m/s].

    Returns:
        The desired V_WE, which points straight to the target and ignores
        constraints, and the executed V_WE. Both are expressed in W, angular
        before translational, shape (6,) [rad/s, m/s].
    """
    state = robot.state(report.q)
    effector, target = report.aim.items[0]
    X_WE = state.X_WEs[effector]
    desired = np.concatenate(
        target_twist(X_WE, target, target.error(X_WE), gain, max_speed)
    )
    return desired, state.J_WE(effector) @ executed


def deviation(desired: np.ndarray, executed: np.ndarray) -> float:
    """Returns the norm of desired minus executed translational velocity [m/s].

    The paper's figure 5 plots this.

    Args:
        desired: The desired V_WE, shape (6,) [rad/s, m/s].
        executed: The executed V_WE, shape (6,) [rad/s, m/s].
    """
    return float(np.linalg.norm(desired[3:] - executed[3:]))
