"""`TickReport`: inputs, decision and reasons of one control tick."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.payload import Payload
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import NONE_BINDS, Binding, BoundRow
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.separation import Separation
from remosplat_drake.signals.target import Target

OPTIMAL = "optimal"
"""Status of a tick whose quadratic program was solved without changes."""
ACCELERATION_DROPPED = "acceleration_dropped"
"""Status of a tick whose program was solved without acceleration bounds."""
RELAXED = "relaxed"
"""Status of a tick whose program was solved after its rows were relaxed.

Some rows demand that the robot retreats from an obstacle. The demands of these
rows are multiplied by the greatest common factor for which the program is
feasible.
"""
BRAKING = "braking"
"""Status of a tick without a usable program: the command ramps down to zero."""

STATUSES = (OPTIMAL, ACCELERATION_DROPPED, RELAXED, BRAKING)
"""All statuses of a tick, the best first."""


@dc.dataclass(frozen=True, eq=False)
class TickReport:
    """Inputs, decision and reasons of one tick; a copy is the object itself.

    Attributes:
        time: Time of the tick [s]; NaN before the first one.
        q: Measured configuration at the start of the tick, shape (n_q,) [m,
            rad].
        command: Commanded velocity u, held until the next tick, shape (n_u,)
            [m/s, rad/s].
        status: One of `STATUSES`.
        reason: Reason why the status is not `OPTIMAL`, with the names of the
            relaxed constraints; empty if it is `OPTIMAL`.
        scale: Factor of the command after verification, from braking (0) to the
            program's optimum (1).
        clearances: All rows of the distance oracle within the influence
            distance.
        kept: Whether each row of `clearances` is in the program, shape (m,),
            bool. The velocity bounds imply all other rows.
        tight: Whether each row of `clearances` holds with equality at the
            program's optimum, before verification (an active constraint), shape
            (m,), bool.
        aim: The targets of the end effectors at this tick.
        binding: All rows of any kind that hold with equality at the program's
            optimum, and the negative gradient of the cost there.
        inside: The row with the largest violation of a joint limit, or of a
            stopping distance from the scene or between links. It is None if no
            violation exceeds rounding errors.
        line_deviation: Largest deviation of end effectors from the lines of
            their targets [m]; NaN without lines.
        objection: The constraint because of which verification rejected the
            program's optimum: `COLLISION`, `JOINT_LIMIT`, `SELF_COLLISION` or
            `MOVER`; empty if verification accepted the optimum.
        separation: Distance and protective separation distance of the pair of
            link and mover with the least margin; None without movers.
        payload: The object that the robot carried at this tick; None if it
            carried nothing. In `clearances`, the spheres of the object follow
            those of the robot.
        timings: Wall-clock time of each phase [s]. The phases are `guidance`
            (in the previous period), `oracle`, `solve` (only if one of Drake's
            solvers is used), `tick` (kinematics, program, decision,
            verification), and `total`.
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
    aim: Aim
    binding: Binding = NONE_BINDS
    inside: BoundRow | None = None
    line_deviation: float = float("nan")
    objection: str = ""
    separation: Separation | None = None
    payload: Payload | None = None
    timings: dict[str, float] = dc.field(default_factory=dict)

    def __deepcopy__(self, memo) -> "TickReport":
        return self

    @property
    def target(self) -> Target:
        """The target of the first end effector that has one."""
        return self.aim.first

    @property
    def X_WT(self) -> np.ndarray:
        """Pose of `target`, shape (4, 4)."""
        return self.target.X_WT

    @property
    def p_WTs(self) -> np.ndarray:
        """Positions of all k targets in W, shape (k, 3) [m]."""
        return self.aim.arrays.X_WT[:, :3, 3]

    @staticmethod
    def before_first(n_q: int, n_u: int) -> "TickReport":
        """Makes the report of a controller before its first tick.

        Args:
            n_q: Number of configuration variables.
            n_u: Number of commanded velocities.
        """
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
            aim=Aim.of(np.full((4, 4), np.nan)),
        )
