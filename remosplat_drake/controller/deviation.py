"""How far the end effector's velocity is from straight to the target."""

import numpy as np

from remosplat_drake.controller.servo import servo_twist
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.tick_report import TickReport


def end_effector_velocities(
    report: TickReport,
    executed: np.ndarray,
    robot: RobotModel,
    gain: float,
    max_speed: float,
) -> tuple[np.ndarray, np.ndarray]:
    """The desired and the executed velocity of E (paper figure 5).

    Args:
        report: Of a tick; before the first one all is NaN.
        executed: Velocity u that the station got, shape (n_u,): the
            controller's, or what the supervisor made of it.
        robot: Finds the end effector.
        gain: The servo's [1/s].
        max_speed: The servo's [m/s].

    Returns:
        V_WE desired, straight to the target without regard to anything
        else, and V_WE executed, both in W, angular above translational,
        shape (6,) [rad/s, m/s].
    """
    state = robot.state(report.q)
    error = pose_error(state.X_WE, report.X_WT)
    desired = np.concatenate(servo_twist(error, gain, max_speed))
    J = np.concatenate([state.Jw_WE, state.Jv_WE])
    return desired, J @ executed


def deviation(desired: np.ndarray, executed: np.ndarray) -> float:
    """The paper's plot: |v desired - v executed|, translation alone [m/s]."""
    return float(np.linalg.norm(desired[3:] - executed[3:]))
