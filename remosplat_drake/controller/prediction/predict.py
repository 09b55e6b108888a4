"""Leads a measurement forward to when the next command takes effect."""

import numpy as np

from remosplat_drake.controller.prediction.history import LONG_AGO, History
from remosplat_drake.controller.verification.kernels.places import chain
from remosplat_drake.robot.actuators import ActuatorModel
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion import Motion

_PIECES = 8
"""Number of arcs along which the base is led forward."""


def predict(
    robot: RobotModel,
    model: ActuatorModel,
    history: History,
    q: np.ndarray,
    stamp: np.ndarray,
    now: float,
) -> Motion:
    """Predicts the motion that the commands up to now have committed.

    Without delays and lags everything stays as it was measured.

    Args:
        robot: The robot.
        model: How its axes follow their commands.
        history: The commands that were sent.
        q: Measured configuration, shape (n_q,) [m, rad].
        stamp: When each axis was measured, shape (n_u,) [s].
        now: When the next command is sent [s].
    """
    stamp = np.clip(stamp, LONG_AGO, now)
    start = now + model.delay.min()
    row = np.searchsorted(history.sent, stamp, side="right") - 1
    row = np.maximum(row, 0)
    axis = np.arange(robot.n_u)
    shares = np.linspace(0.0, 1.0, _PIECES + 1)[:, None]
    until = np.concatenate(
        [
            stamp + shares * (start - stamp),
            start + shares[1:] * (now + model.delay - start),
        ]
    )
    way, v = model.response(
        history.sent,
        history.u,
        history.sent[row],
        history.v[row, axis],
        np.maximum(until, history.sent[row]),
    )
    q_start = _led(robot, q, np.diff(way[: _PIECES + 1], axis=0))
    rest = np.vstack([np.diff(way[_PIECES:], axis=0), model.lag * v[-1]])
    return Motion(
        model=model,
        time=now,
        sent=history.sent,
        u=history.u,
        start=start,
        q_start=q_start,
        v_start=v[_PIECES],
        q_planned=_led(robot, q_start, rest),
        v_measured=v[0],
        way_measured=history.way[row, axis] + way[0],
        residual=history.residual(now),
        bound=model.tube * history.peak() + model.noise,
    )


def modelled_way(
    model: ActuatorModel, history: History, stamp: np.ndarray
) -> np.ndarray:
    """Returns the model's ways since the beginning at some times, (n_u,).

    Args:
        model: How the axes follow their commands.
        history: The commands that were sent.
        stamp: A time for each axis, shape (n_u,) [s].
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


def _led(robot: RobotModel, q: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Leads a configuration along s short ways, shape (s, n_u)."""
    if not ways.any():
        return q
    # Each way takes one unit of time; where one more would begin is the end.
    return chain(q, ways, np.ones(len(ways) + 1), robot.n_base)[-1]
