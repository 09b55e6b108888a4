"""`OperatorCommand`: all that an operator has asked of the target so far."""

import dataclasses as dc

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class OperatorCommand:
    """All that one operator has asked of the target; copying returns itself.

    What happens once is counted, and a higher count than the one known before
    is the wish: no press is lost between two looks, and nobody need reset
    anything. Of several new wishes the first in the order hold, home, pose,
    scan, velocity, moves is obeyed, by the end effector that was chosen last.

    Attributes:
        source: Name of the device that the operator uses, for display.
        X_WT: Wished pose of the target T in W, shape (4, 4); None before there
            was one.
        moves: Number of times that the operator took hold of `X_WT`. A slider
            counts each change by hand, and none that only shows where the
            target went; a stream of poses counts once when it begins.
        V_W: Wished velocity of the target, angular above translational, shape
            (6,) [rad/s, m/s]; None unless the operator holds the dead-man
            button.
        holds: Number of times that the target was told to stay where it is.
        homes: Number of times that the target was sent home.
        pose: Name of the saved pose that was picked last.
        poses: Number of times that a saved pose was picked.
        scans: Number of times that a scan was asked for.
        effector: Name of the end effector that was chosen last; empty for the
            first, or an only one.
        choices: Number of times that an end effector was chosen.
        trouble: Why `X_WT` must not be followed now; empty while it may be.
    """

    source: str = ""
    X_WT: np.ndarray | None = None
    moves: int = 0
    V_W: np.ndarray | None = None
    holds: int = 0
    homes: int = 0
    pose: str = ""
    poses: int = 0
    scans: int = 0
    effector: str = ""
    choices: int = 0
    trouble: str = ""

    def __deepcopy__(self, memo) -> "OperatorCommand":
        return self
