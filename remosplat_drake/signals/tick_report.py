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
"""Status of a tick whose program was solved after relaxation.

Rows that demand a retreat are scaled by the greatest common factor that makes
the program feasible.
"""
BRAKING = "braking"
"""Status of a tick without a usable program: the command ramps down to zero."""

STATUSES = (OPTIMAL, ACCELERATION_DROPPED, RELAXED, BRAKING)
"""All statuses of a tick, the best first."""


@dc.dataclass(frozen=True, eq=False)
class TickReport:
    """Inputs, decision and reasons of one tick; copies are the object itself.

    Attributes:
        time: Time of the tick [s]; NaN before the first one.
        q: Measured configuration that the tick started from, shape (n_q,) [m,
            rad].
        command: Commanded velocity u, held until the next tick, shape (n_u,)
            [m/s, rad/s].
        status: One of `STATUSES`.
        reason: Why the status is not `OPTIMAL`, with the names of the relaxed
            constraints; empty otherwise.
        scale: Scale of the command after verification, from braking (0) to the
            program's optimum (1).
        clearances: The oracle's result: all rows within the influence distance.
        kept: Which rows of `clearances` could be active, shape (m,), bool; the
            velocity bounds imply the others.
        tight: Which rows of `clearances` hold with equality at the program's
            optimum (active constraints), before verification, shape (m,), bool.
        aim: The targets of the end effectors at this tick.
        binding: All rows of any kind that hold with equality at the program's
            optimum, and the push against them.
        inside: The row of the deepest violation of a stopping distance, to the
            scene or to the robot itself, or of a joint limit. None if there is
            no notable one.
        line_deviation: Largest deviation of end effectors from the lines of
            their targets [m]; NaN without lines.
        objection: The constraint for which verification rejected the program's
            optimum: `COLLISION`, `JOINT_LIMIT`, `SELF_COLLISION` or `MOVER`;
            empty if it accepted the optimum.
        separation: Distance and protective separation distance of the pair of
            link and mover with the least margin; None without movers.
        payload: The object that the robot carried at this tick; its spheres
            follow the robot's in `clearances`. None for nothing.
        timings: Wall-clock time of each phase [s]: guidance (in the previous
            period), oracle, solve (only if one of Drake's solvers is used),
            tick (kinematics, program, decision, verification), total.
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
        """The target of the first or only end effector that has one."""
        return self.aim.first

    @property
    def X_WT(self) -> np.ndarray:
        """Pose of that target, shape (4, 4)."""
        return self.target.X_WT

    @property
    def p_WTs(self) -> np.ndarray:
        """Positions of all k targets in W, shape (k, 3) [m]."""
        return self.aim.arrays.X_WT[:, :3, 3]

    @staticmethod
    def before_first(n_q: int, n_u: int) -> "TickReport":
        """Makes the report of a controller that has not ticked yet.

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
