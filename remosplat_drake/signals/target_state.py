"""`TargetState`: where the target is, where it goes, and why."""

import dataclasses as dc

import numpy as np

from remosplat_drake.signals.operator_command import OperatorCommand

HOLD = "hold"
"""The target rests where the end effector was when the hold began."""
FOLLOW = "follow"
"""It moves to the pose that the operator wishes for."""
VELOCITY = "velocity"
"""It moves as the operator's stick says, while the button is held."""
GO = "go"
"""It moves home or to a saved pose."""
SCAN = "scan"
"""It goes through the poses of a scan."""

MODES = (HOLD, FOLLOW, VELOCITY, GO, SCAN)


@dc.dataclass(frozen=True, eq=False)
class TargetState:
    """The target after a tick; copying returns the object itself.

    Attributes:
        mode: One of `MODES`.
        X_WT: Pose of the target, shape (4, 4).
        V_WT: Its velocity in W, angular above translational, (6,)
            [rad/s, m/s].
        X_WT_goal: Where it goes, within the workspace, shape (4, 4).
        text: What it does and why, for people to read.
        command: What the operator had asked for by then.
        scan: Poses of the scan that are left, the present one first.
        scan_size: How many poses the scan had.
        shown: When the target came to the present pose of the scan [s];
            None before.
        arrived: When the end effector came to it [s]; None before.
        frames_wanted: How many frames scans have asked for.
        unfinished: Those of them that more of their scan followed or will;
            one less when a scan is broken off.
    """

    mode: str
    X_WT: np.ndarray
    V_WT: np.ndarray
    X_WT_goal: np.ndarray
    text: str = ""
    command: OperatorCommand = dc.field(default_factory=OperatorCommand)
    scan: tuple[np.ndarray, ...] = ()
    scan_size: int = 0
    shown: float | None = None
    arrived: float | None = None
    frames_wanted: int = 0
    unfinished: int = 0

    @staticmethod
    def at_rest(X_WT: np.ndarray, text: str = "") -> "TargetState":
        """A target that rests."""
        return TargetState(HOLD, X_WT, np.zeros(6), X_WT, text)

    def __deepcopy__(self, memo) -> "TargetState":
        return self
