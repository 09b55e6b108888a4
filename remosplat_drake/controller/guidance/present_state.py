"""`PresentState`: robot and movers, as a decision about guidance starts."""

import dataclasses as dc

import numpy as np

from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.aim import Aim


@dc.dataclass(frozen=True, eq=False)
class PresentState:
    """The state from which a decision starts.

    Attributes:
        time: Present time [s].
        q: Measured configuration, shape (n_q,) [rad, m].
        u: Command being executed, shape (n_u,).
        aim: What the end effectors shall reach.
        movers: What moves; None if nothing is known to.
    """

    time: float
    q: np.ndarray
    u: np.ndarray
    aim: Aim
    movers: Movers | None = None
