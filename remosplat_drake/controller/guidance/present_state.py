"""`PresentState`: the state of robot and movers when guidance is selected."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.motion import Motion


@dc.dataclass(frozen=True, eq=False)
class PresentState:
    """The state of robot and movers from which guidance is selected.

    Attributes:
        time: Present time [s].
        q: Configuration from which rollouts start, shape (n_q,) [rad, m].
        u: Command that is being executed, shape (n_u,).
        aim: The targets of the end effectors.
        movers: The movers; None if none are known.
        motion: Predicted motion that is caused by commands sent so far; None
            for a robot without delay.
        payload: The payload; None if the robot carries nothing.
    """

    time: float
    q: np.ndarray
    u: np.ndarray
    aim: Aim
    movers: Movers | None = None
    motion: Motion | None = None
    payload: Payload | None = None
