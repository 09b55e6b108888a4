"""`Rollout`: a simulation of the control loop on the known map."""

import dataclasses as dc
import math
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.guidance.kernels.rollout_steps import (
    rollout_steps,
)
from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.tick_calls import TickCalls
from remosplat_drake.controller.tick.tick_inputs import TickInputs
from remosplat_drake.controller.verification.map_calls import (
    map_for_kernels,
    rows_for_kernels,
)
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.scene.mover import FORESIGHT, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import MotionArrays, prompt_motion
from remosplat_drake.signals.target import Target

RUNNING, REACHED, STALLED, HORIZON = "running", "reached", "stalled", "horizon"
"""Statuses of a rollout. All statuses except the first are final."""

OUTRUN = "outrun"
"""Final status of a rollout if another rollout from the same start has a lower
score."""

_STALL_SPEED = 0.012
"""Below this speed, the robot counts as standing still. The speed is the
greater of the base's |v| [m/s] and half the largest joint rate [rad/s, m/s]."""

_STALL_TIME = 0.5
"""If the robot has stood still for this time, the rollout has stalled [s]."""

STRIDE = 5
"""Number of steps in one call of the kernel. Steps after the end of a rollout
are computed in vain, but calls of single steps would take a fifth longer,
because caches are cold."""

_LATER = "sent", "u", "time", "start", "v_start", "q_start"
"""The fields of `MotionArrays` that change from step to step."""

_Steps = tuple[np.ndarray, np.ndarray, np.ndarray]
"""For each step, the command, the configuration q after it, and the poses X_WE
at q."""


@dc.dataclass(frozen=True, eq=False)
class Rollout:
    """A simulation of the closed loop, advanced by a few steps at a time.

    Attributes:
        guidance: The candidate that is simulated.
        q: Configuration reached so far, shape (n_q,) [rad, m].
        u: Command that is being executed at q, shape (n_u,).
        time: Simulated time since the start [s].
        still: Simulated time for which the robot has stood still [s].
        status: One of RUNNING, REACHED, STALLED, HORIZON and OUTRUN.
        position_error: Distance from an end effector to its target at q; the
            largest one if there are several targets [m].
        angle_error: Angle between an end effector and its target at q; the
            largest one if there are several targets [rad].
        path: Positions in W, so far, of the first end effector that has a
            target, each of shape (3,) [m].
        movers: The movers around the robot at the start of the rollout; None if
            no movers were known.
        start: Time at which the rollout starts [s].
        motion: Predicted motion that is caused by commands sent so far; None
            for a robot without delay.
    """

    guidance: Guidance
    q: np.ndarray
    u: np.ndarray
    time: float = 0.0
    still: float = 0.0
    status: str = RUNNING
    position_error: float = math.inf
    angle_error: float = math.inf
    path: tuple[np.ndarray, ...] = ()
    movers: Movers | None = None
    start: float = 0.0
    motion: Packed[MotionArrays] | None = None

    def __deepcopy__(self, memo) -> "Rollout":
        return self

    @property
    def num_steps(self) -> int:
        """Number of steps that have been simulated."""
        return len(self.path)

    def ended(self, status: str) -> "Rollout":
        """Returns this rollout with a final status.

        Args:
            status: The final status.
        """
        return dc.replace(self, status=status)

    def score(self, first_tier: float) -> float:
        """Computes the rollout's score [s]; lower is better.

        The score of a rollout that reaches the target is its `arrival`. The
        score of any other rollout is 58 s plus a term that increases with its
        final error. A rollout with the status OUTRUN is never the best.

        Args:
            first_tier: The stopping distance of the first tier [m].
        """
        if self.status == REACHED:
            return self.arrival(first_tier)
        if self.status == OUTRUN:
            return math.inf
        return 58.0 + 10.0 * self.position_error + self.angle_error

    def arrival(self, first_tier: float) -> float:
        """Returns the score of a rollout that arrives at its present time [s].

        It is the time until the target is reached, plus 4 s for each 10 mm by
        which the stopping distance is reduced.

        Args:
            first_tier: The stopping distance of the first tier [m].
        """
        stopping = self.guidance.stopping
        given_up = 0.0 if stopping is None else first_tier - stopping
        return self.time + 400.0 * given_up


def advance_rollout(
    law: ReactiveLaw,
    rollout: Rollout,
    field: DistanceField,
    aim: Aim | Target | np.ndarray,
    arrived: Callable[[PoseError], bool],
    horizon: float,
    steps: int = 1,
) -> Rollout:
    """Advances a rollout by the control tick that also drives the robot.

    Movers keep their twists for the time `FORESIGHT`, and are at rest
    afterwards. At each step, the age of their measurements is that at the start
    of the rollout. A robot that stands still while a mover moves has not
    stalled, since it may be waiting for the mover.

    Args:
        law: The control law, with the rollout's step as its period.
        rollout: The rollout so far.
        field: The map.
        aim: The targets of the end effectors, as an `Aim`. A `Target` or a pose
            X_WT of shape (4, 4) is also accepted; it is the target of the first
            end effector.
        arrived: Function that returns whether a `PoseError` counts as arrival.
        horizon: Simulated time at which the rollout ends at the latest [s].
        steps: Number of steps. Fewer steps are simulated if the rollout ends.

    Returns:
        The rollout after these steps.
    """
    aim = Aim.of(aim)
    while steps > 0 and rollout.status == RUNNING:
        before = rollout.num_steps
        stride = min(steps, STRIDE)
        simulated, motion = _simulated(law, rollout, field, aim, stride)
        rollout = _followed(law, rollout, simulated, aim, arrived, horizon)
        rollout = dc.replace(rollout, motion=motion)
        steps -= rollout.num_steps - before
    return rollout


def _followed(
    law: ReactiveLaw,
    rollout: Rollout,
    simulated: _Steps,
    aim: Aim,
    arrived: Callable[[PoseError], bool],
    horizon: float,
) -> Rollout:
    """Returns the rollout after simulated steps; omits steps after its end."""
    # If there is no path, a robot that only turns its base counts as standing
    # still.
    n_moves = law.robot.n_base - (rollout.guidance.path is None)
    anything_moves = _anything_moves(rollout.movers)
    time, still, path = rollout.time, rollout.still, list(rollout.path)
    status, errors, k = RUNNING, (), -1
    us, qs, X_WEs = simulated
    while status == RUNNING and k + 1 < len(us):
        k += 1
        errors = aim.errors(X_WEs[k])
        time += law.dt
        waits = anything_moves and time <= FORESIGHT
        stands = _stands(law, us[k], n_moves) and not waits
        still = still + law.dt if stands else 0.0
        path.append(X_WEs[k, aim.items[0][0], :3, 3])
        if aim.is_reached_by(errors, arrived):
            status = REACHED
        elif still >= _STALL_TIME - 1e-9:
            status = STALLED
        elif time >= horizon - 1e-9:
            status = HORIZON
    return dc.replace(
        rollout,
        q=qs[k],
        u=us[k],
        time=time,
        still=still,
        status=status,
        position_error=max(error.distance for error in errors),
        angle_error=max(error.angle for error in errors),
        path=tuple(path),
    )


def _simulated(
    law: ReactiveLaw,
    rollout: Rollout,
    field: DistanceField,
    aim: Aim,
    steps: int,
) -> tuple[_Steps, Packed[MotionArrays]]:
    """Simulates steps; returns them and the motion after the last one."""
    motion = rollout.motion or prompt_motion(law.robot.n_u)
    given = TickInputs(
        rollout.start, aim, field, rollout.guidance, motion, rollout.movers
    )
    with TickCalls(law, given) as line:
        us, qs, X_WEs, after = rollout_steps(
            law.arrays,
            law.robot.arrays,
            rows_for_kernels(field),
            *map_for_kernels(field),
            given.moving.arrays,
            given.moving.age(rollout.start),
            motion,
            float(rollout.start),
            float(rollout.time),
            aim.arrays,
            # The arrays are copied, since kernels are compiled for writable
            # arrays.
            np.array(rollout.q, float),
            np.array(rollout.u, float),
            rollout.guidance.arrays,
            steps,
            line,
        )
    if motion.is_late:
        later = dict(zip(_LATER, after, strict=True))
        motion = Packed(motion.values._replace(**later))
    return (us, qs, X_WEs), motion


def _anything_moves(movers: Movers | None) -> bool:
    return movers is not None and any(m.speed > _STALL_SPEED for m in movers)


def _stands(law: ReactiveLaw, u: np.ndarray, n_moves: int) -> bool:
    speeds = [abs(speed) for speed in u.tolist()]
    base = max(speeds[: max(n_moves, 0)], default=0.0)
    arm = max(speeds[law.robot.n_base :], default=0.0)
    return max(base, 0.5 * arm) < _STALL_SPEED
