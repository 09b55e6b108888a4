"""`SupervisorState`: the safety supervisor's mode, command and reasons."""

import dataclasses as dc
import math
from collections.abc import Mapping

import numpy as np

from remosplat_drake.robot.payload import Payload

STARTING = "starting"
"""Mode in which the command is zero until measurements and a command arrive."""
RUNNING = "running"
"""Mode in which the controller's commands are passed on."""
STOPPING = "stopping"
"""Mode in which the command ramps down to zero."""
STOPPED = "stopped"
"""Mode in which the command is zero until an explicit release."""

ASKED, LOST, SCANNER = "operator", "localization", "protective_stop"
"""Names of three symptoms. In order: an operator has pressed STOP, the base's
pose is too uncertain, and the safety scanner has stopped the base."""

ARM_MODE, ARM_RATE = "robot_mode", "success_rate"
"""Names of two symptoms. In order: the arm is in another mode, such as a
reflex, and too few commands reach the arm in time."""

CLEARANCE, JUMP = "clearance", "target"
"""Names of two symptoms. In order: the clearance is below its limit, and the
target has jumped."""

UNARMED = "waiting for an operator to arm"
"""Reason of the stop with which every run of a real robot begins."""

LATCHED = (STOPPING, STOPPED)
"""Modes that only a release ends."""


@dc.dataclass(frozen=True, eq=False)
class SupervisorState:
    """State of the safety supervisor; copying returns the object itself.

    Attributes:
        command: Velocity command u for the robot until the next tick, shape
            (n_u,) [m/s, rad/s].
        mode: One of `STARTING`, `RUNNING`, `STOPPING` and `STOPPED`.
        reason: Reason why the supervisor stopped the robot, or the condition
            that is missing for a start; empty while the robot runs.
        symptom: Name of the rule that stopped the robot; empty if no rule has.
        axis: Index in u of the axis that the reason concerns; None if it
            concerns no single axis.
        refusal: Reason why the latest request for a release was refused; empty
            if it was not.
        time: Time of the latest tick [s]; NaN before the first one.
        p_WTs: Positions of the k targets at the latest tick, shape (k, 3) [m].
        kept_clearance: The largest clearance since the start of motion [m].
        since: Time at which each current symptom began [s], keyed by its name.
        payload: The object that the robot carried at the latest tick; None if
            it carried nothing.
        map_revision: Revision of the latest map in which the clearance was
            above its limit.
    """

    command: np.ndarray
    mode: str = STARTING
    reason: str = ""
    refusal: str = ""
    symptom: str = ""
    axis: int | None = None
    time: float = math.nan
    p_WTs: np.ndarray = dc.field(
        default_factory=lambda: np.full((1, 3), np.nan)
    )
    kept_clearance: float = -math.inf
    since: Mapping[str, float] = dc.field(default_factory=dict)
    payload: Payload | None = None
    map_revision: str = ""

    def __deepcopy__(self, memo) -> "SupervisorState":
        return self

    @property
    def runs(self) -> bool:
        """Whether the controller's commands are passed on."""
        return self.mode == RUNNING

    @property
    def is_latched(self) -> bool:
        """Whether only a release lets the robot move again."""
        return self.mode in LATCHED
