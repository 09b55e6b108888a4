"""The results of the kernels of `prediction`, slowly and readably.

It is what tests hold them against.
"""

import numpy as np

from remosplat_drake.controller.prediction.history import LONG_AGO, History
from remosplat_drake.controller.prediction.kernels.lead_forward import PIECES
from remosplat_drake.controller.verification.kernels.places import chain
from remosplat_drake.robot.actuators import ActuatorModel


def append_command(
    model: ActuatorModel,
    history: History,
    time: float,
    u: np.ndarray,
    span: float,
) -> tuple[np.ndarray, ...]:
    """Adds a command; see `kernels/append_command.py`."""
    way, v = model.response(
        history.sent,
        history.u,
        np.full(len(u), history.sent[-1]),
        history.v[-1],
        np.full((1, len(u)), time),
    )
    first = max(int(np.searchsorted(history.sent, time - span)) - 1, 0)
    return (
        np.append(history.sent[first:], time),
        np.vstack([history.u[first:], u]),
        np.vstack([history.v[first:], v]),
        np.vstack([history.way[first:], history.way[-1] + way]),
        np.vstack([history.drift[first:], history.drift[-1]]),
    )


def lead_forward(
    model: ActuatorModel,
    history: History,
    q: np.ndarray,
    stamp: np.ndarray,
    now: float,
    n_base: int,
) -> tuple:
    """Leads a measurement forward; see `kernels/lead_forward.py`."""
    stamp = np.clip(stamp, LONG_AGO, now)
    start = now + model.delay.min()
    row = np.searchsorted(history.sent, stamp, side="right") - 1
    row = np.maximum(row, 0)
    axis = np.arange(len(stamp))
    shares = np.linspace(0.0, 1.0, PIECES + 1)[:, None]
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
    q_start = _led(q, np.diff(way[: PIECES + 1], axis=0), n_base)
    rest = np.vstack([np.diff(way[PIECES:], axis=0), model.lag * v[-1]])
    return (
        start,
        q_start,
        v[PIECES],
        _led(q_start, rest, n_base),
        v[0],
        history.way[row, axis] + way[0],
    )


def _led(q: np.ndarray, ways: np.ndarray, n_base: int) -> np.ndarray:
    """Leads a configuration along s short ways, shape (s, n_u)."""
    if not ways.any():
        return q
    # Each way takes one unit of time; where one more would begin is the end.
    return chain(q, ways, np.ones(len(ways) + 1), n_base)[-1]
