"""`SimulatedPanda`: a simulated arm that is driven by libfranka's law."""

import numpy as np

from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    PANDA,
    POSITION_LOWER,
    POSITION_UPPER,
    JointCommand,
    next_command,
)
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmLimits,
    SimulatedArm,
)

LIMITS = ArmLimits(
    POSITION_LOWER, POSITION_UPPER, PANDA.velocity, PANDA.acceleration
)
"""Limits of a Panda."""


class SimulatedPanda(SimulatedArm):
    """Simulates a Panda's driver, with libfranka's limits on jerk."""

    def __init__(self):
        """Starts in velocity control, at rest."""
        super().__init__(LIMITS)
        self._command = AT_REST

    def _next(self, target: np.ndarray) -> JointCommand:
        return next_command(target, self._command)
