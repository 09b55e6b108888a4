"""`PresentState`: robot and movers, as a decision about guidance starts."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.motion import Motion


@dc.dataclass(frozen=True, eq=False)
class PresentState:
    """The state from which a decision starts.

    Attributes:
        time: Present time [s].
        q: Configuration to plan from, shape (n_q,) [rad, m].
        u: Command being executed, shape (n_u,).
        aim: The targets of the end effectors.
        movers: The movers; None if none are known.
        motion: The motion that commands in flight lead to; None for a robot
            without delay.
        payload: What the robot carries; None for nothing.
    """

    time: float
    q: np.ndarray
    u: np.ndarray
    aim: Aim
    movers: Movers | None = None
    motion: Motion | None = None
    payload: Payload | None = None
