"""Predicts the state at the time at which the next command acts."""

import numpy as np

from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.kernels.lead_forward import (
    lead_forward,
)
from remosplat_drake.robot.actuators import ActuatorModel
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion import Motion


def predict(
    robot: RobotModel,
    model: ActuatorModel,
    history: History,
    q: np.ndarray,
    stamp: np.ndarray,
    now: float,
    slack: float = 0.0,
) -> Motion:
    """Predicts the motion that all commands sent so far cause.

    If the model has no delays and lags, the predicted configuration is the
    measured configuration.

    Args:
        robot: The robot.
        model: Actuator model of the robot's axes.
        history: The commands that were sent.
        q: Measured configuration, shape (n_q,) [m, rad].
        stamp: Time at which each axis was measured, shape (n_u,) [s].
        now: Time at which the next command is sent [s].
        slack: Commands act at most this much later than in the model [s].
    """
    # The arrays are copied, since kernels are compiled for writable arrays.
    start, q_start, v_start, q_planned, v_measured, way_measured = lead_forward(
        model.parameters,
        (history.sent, history.u, history.v, history.way),
        np.array(q, float),
        np.array(stamp, float),
        float(now),
        robot.n_base,
    )
    return Motion(
        model=model,
        time=now,
        sent=history.sent,
        u=history.u,
        start=start,
        q_start=q_start,
        v_start=v_start,
        tube=model.tube + slack,
        q_planned=q_planned,
        v_measured=v_measured,
        way_measured=way_measured,
        residual=history.residual(now),
        bound=model.tube * history.peak() + model.noise,
    )


def modelled_way(
    model: ActuatorModel, history: History, stamp: np.ndarray
) -> np.ndarray:
    """Returns the distance of each axis in the model, shape (n_u,) [m, rad].

    The distance is measured from the start of the history.

    Args:
        model: Actuator model of the axes.
        history: The commands that were sent.
        stamp: The time for each axis, shape (n_u,) [s].
    """
    row = np.maximum(np.searchsorted(history.sent, stamp, side="right") - 1, 0)
    axis = np.arange(len(stamp))
    way, _ = model.response(
        history.sent,
        history.u,
        history.sent[row],
        history.v[row, axis],
        np.maximum(stamp, history.sent[row])[None],
    )
    return history.way[row, axis] + way[0]
