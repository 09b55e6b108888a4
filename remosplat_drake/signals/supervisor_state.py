"""`SupervisorState`: what the supervisor is at, and why."""

import dataclasses as dc
import math
from collections.abc import Mapping

import numpy as np

STARTING = "starting"
"""From a standstill, as soon as there are measurements and a command."""
RUNNING = "running"
"""The controller's commands are passed on."""
STOPPING = "stopping"
"""The command ramps down to zero."""
STOPPED = "stopped"
"""Zero until an explicit release."""

LATCHED = (STOPPING, STOPPED)
"""Modes that only a release ends."""


@dc.dataclass(frozen=True, eq=False)
class SupervisorState:
    """What the supervisor remembers; copying returns the object itself.

    Attributes:
        command: What the robot is to do until the next tick, shape (n_u,).
        mode: STARTING, RUNNING, STOPPING or STOPPED.
        reason: Why it stopped, or what it waits for; empty while running.
        refusal: Why the latest release was not granted.
        time: Of the latest tick [s]; NaN before the first one.
        p_WT: Target of the latest tick, shape (3,) [m].
        since: When each present symptom began [s].
        map_revision: Of the latest map that left the robot enough clearance.
    """

    command: np.ndarray
    mode: str = STARTING
    reason: str = ""
    refusal: str = ""
    time: float = math.nan
    p_WT: np.ndarray = dc.field(default_factory=lambda: np.full(3, np.nan))
    since: Mapping[str, float] = dc.field(default_factory=dict)
    map_revision: str = ""

    def __deepcopy__(self, memo) -> "SupervisorState":
        return self

    @property
    def is_latched(self) -> bool:
        """Whether only a release lets the robot move on."""
        return self.mode in LATCHED
