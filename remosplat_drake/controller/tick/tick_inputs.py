"""`TickInputs`: the inputs of a control tick."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.robot.robot_arrays import StateArrays
from remosplat_drake.scene.mover import FORESIGHT, STILL, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.motion import MotionArrays


@dc.dataclass(frozen=True, eq=False)
class TickInputs:
    """The inputs of a control tick, or of a rollout that begins with this tick.

    Attributes:
        time: Time of the tick [s].
        aim: The targets of the end effectors.
        field: The map. Verification of a command queries it along the path.
        guidance: The guidance.
        motion: Predicted motion that is caused by commands sent so far.
        movers: The movers; None if none are known.
    """

    time: float
    aim: Aim
    field: DistanceField
    guidance: Guidance
    motion: Packed[MotionArrays]
    movers: Movers | None = None

    @property
    def moving(self) -> Movers:
        """The movers; an empty `Movers` if none are known."""
        return STILL if self.movers is None else self.movers

    def tick(
        self,
        law: ReactiveLaw,
        state: StateArrays,
        u_previous: np.ndarray,
        clearances: Clearances,
        ahead: float = 0.0,
    ) -> Tick:
        """Returns the inputs of ingredients in Python.

        Args:
            law: The control law.
            state: Kinematics of the configuration for which the command is
                computed.
            u_previous: The command that is being executed, shape (n_u,).
            clearances: The distances and directions of the distance oracle at
                q.
            ahead: Time since the start of the rollout [s].
        """
        tube, movers = None, self.movers
        if self.motion.is_late:
            speed = np.abs(u_previous)
            tube = law.robot.sphere_tube(self.motion.tube, speed)
        if movers is not None and ahead:
            movers = movers.moved_on(ahead, FORESIGHT)
        return Tick(
            law.robot,
            law.robot.state_of(state),
            self.aim,
            clearances,
            u_previous,
            law.dt,
            self.guidance,
            tube,
            movers,
            self.time,
        )
