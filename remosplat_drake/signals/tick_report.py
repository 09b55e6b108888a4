"""`TickReport`: what one control tick saw, decided and why."""

import dataclasses as dc

import numpy as np

from remosplat_drake.signals.distance_field import Clearances

OPTIMAL = "optimal"
"""The program was solved as it stands."""
ACCELERATION_DROPPED = "acceleration_dropped"
"""Solved after the acceleration bounds were left out."""
RELAXED = "relaxed"
"""Solved after negative right-hand sides were raised to zero."""
BRAKING = "braking"
"""No usable program: the command ramps down to zero."""

STATUSES = (OPTIMAL, ACCELERATION_DROPPED, RELAXED, BRAKING)


@dc.dataclass(frozen=True, eq=False)
class TickReport:
    """The record of one control tick; copying returns the object itself.

    Attributes:
        time: Time of the tick [s]; NaN before the first one.
        q: Configuration that the tick started from, shape (n_q,).
        command: Commanded velocity u, held until the next tick, (n_u,).
        status: One of `STATUSES`.
        reason: Why the status is not `optimal`; empty otherwise. Names the
            constraints that had to yield.
        scale: How far verification let the command go from braking (0) to
            what the program wanted (1).
        clearances: What the oracle said, all rows within influence.
        kept: Rows of `clearances` that could bind, shape (m,) bool: the
            others are implied by the velocity bounds.
        tight: Rows that hold with equality at the program's optimum, before
            verification, shape (m,) bool.
        X_WT: Target pose of this tick, shape (4, 4).
        timings: Wall-clock seconds by phase: guidance (of the period
            before), oracle, kinematics, build, solve, verify, total.
    """

    time: float
    q: np.ndarray
    command: np.ndarray
    status: str
    reason: str
    scale: float
    clearances: Clearances
    kept: np.ndarray
    tight: np.ndarray
    X_WT: np.ndarray
    timings: dict[str, float] = dc.field(default_factory=dict)

    def __deepcopy__(self, memo) -> "TickReport":
        return self

    @staticmethod
    def before_first(n_q: int, n_u: int) -> "TickReport":
        """The report of a controller that has not ticked yet."""
        none = np.zeros(0, bool)
        return TickReport(
            time=float("nan"),
            q=np.full(n_q, np.nan),
            command=np.zeros(n_u),
            status=BRAKING,
            reason="not started",
            scale=1.0,
            clearances=Clearances.none(),
            kept=none,
            tight=none,
            X_WT=np.full((4, 4), np.nan),
        )
