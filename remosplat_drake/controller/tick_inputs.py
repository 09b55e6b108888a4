"""`TickInputs`: what a control tick is given."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import STILL, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion import Motion


@dc.dataclass(frozen=True, eq=False)
class TickInputs:
    """What a control tick is given.

    Attributes:
        time: Time of the tick [s].
        q: Configuration to plan from, finite, shape (n_q,) [rad, m].
        aim: What the end effectors shall reach.
        clearances: The oracle's answer at q, all within the influence distance.
        field: The map, which verification asks along the command's path.
        u_previous: The command being executed, shape (n_u,).
        guidance: How the tick is bent.
        state: Kinematics at q, if the caller has them already.
        motion: What the robot is about to do already; None where it obeys at
            once.
        movers: What moves; None if nothing is known to.
    """

    time: float
    q: np.ndarray
    aim: Aim
    clearances: Clearances
    field: DistanceField
    u_previous: np.ndarray
    guidance: Guidance = DIRECT
    state: RobotState | None = None
    motion: Motion | None = None
    movers: Movers | None = None

    @property
    def moving(self) -> Movers:
        """What moves; nothing if nothing is known to."""
        return STILL if self.movers is None else self.movers
