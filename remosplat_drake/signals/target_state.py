"""`TargetState`: pose, goal and mode of the target in teleoperation."""

import dataclasses as dc

import numpy as np

from remosplat_drake.signals.operator_command import OperatorCommand

HOLD = "hold"
"""Mode in which the target is at the end effector's initial pose.
"""
FOLLOW = "follow"
"""Mode in which the target moves to the pose that the operator requests."""
VELOCITY = "velocity"
"""Mode in which the target moves at the operator's velocity (dead-man button).
"""
GO = "go"
"""Mode in which the target moves home or to a saved pose."""
SCAN = "scan"
"""Mode in which the target visits the poses of a scan."""

MODES = (HOLD, FOLLOW, VELOCITY, GO, SCAN)
"""All modes of a target."""


@dc.dataclass(frozen=True, eq=False)
class TargetState:
    """The target in teleoperation; copying returns the object itself.

    Attributes:
        mode: One of `MODES`.
        X_WT: Pose of the target, shape (4, 4).
        V_WT: Spatial velocity of the target in W, angular before translational,
            shape (6,) [rad/s, m/s].
        X_WT_goal: Pose inside the workspace to which the target moves, shape
            (4, 4).
        text: Sentence about the state of the target and its reason, for
            operators.
        command: The operator's command that led to this state.
        scan: Remaining poses of the scan; the first is the current one.
        scan_size: Number of poses at the start of the scan.
        shown: Time at which the target reached the current pose of the scan
            [s]; None if it has not.
        arrived: Time at which the end effector reached the current pose of the
            scan [s]; None if it has not.
        frames_wanted: Number of camera frames that scans have requested so far.
        unfinished: Number of these frames that are followed by another frame of
            the same scan. It decreases by one if a scan is aborted.
        effector: Index of the end effector that the operator moves.
        X_WTs: Poses of the targets of all e end effectors, shape (e, 4, 4);
            None if there is only one end effector. Targets that the operator
            does not move stay in place.
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
    effector: int = 0
    X_WTs: np.ndarray | None = None

    @staticmethod
    def at_rest(X_WT: np.ndarray, text: str = "") -> "TargetState":
        """Makes the state of a target that rests at X_WT, shape (4, 4)."""
        return TargetState(HOLD, X_WT, np.zeros(6), X_WT, text)

    def __deepcopy__(self, memo) -> "TargetState":
        return self
