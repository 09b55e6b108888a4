"""Verification as ticks run it, asked by itself; and paths to look at."""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.verification.kernels.places import (
    PathArrays,
    places,
)
from remosplat_drake.controller.verification.kernels.stopping import (
    stopping_path,
)
from remosplat_drake.controller.verification.kernels.verified import (
    OBJECTIONS,
    KeptArrays,
    surroundings,
    verified,
)
from remosplat_drake.controller.verification.map_calls import (
    MapCalls,
    map_for_kernels,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.braking import (
    braking_command,
    executed_command,
    spare_time,
)
from remosplat_drake.robot.robot_arrays import RobotArrays, state_arrays
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.kernels.mover_reach import aged
from remosplat_drake.scene.mover import STILL, Movers
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import Motion, prompt_motion


@dc.dataclass(frozen=True, eq=False)
class Around:
    """What verification knows at a tick; attributes are a `Surroundings`'."""

    robot: RobotModel
    field: DistanceField
    state: RobotState
    clearance: np.ndarray
    stopping: float
    dt: float
    limit: np.ndarray
    self_clearance: SelfClearance | None = None
    motion: Motion | None = None
    movers: Movers = STILL
    separation: float = 0.0

    @property
    def arrays(self) -> Packed[RobotArrays]:
        """The robot, with these limits of its acceleration."""
        values = self.robot.arrays.values
        return Packed(values._replace(acceleration_limit=np.array(self.limit)))

    @property
    def start(self) -> np.ndarray:
        """Where a command begins to act."""
        return self.state.q if self.motion is None else self.motion.q_start

    def path(self, u: np.ndarray) -> PathArrays:
        return make_path(self.arrays, self.start, u, self.dt, self.motion)


def make_path(
    robot: Packed[RobotArrays],
    q: np.ndarray,
    u: np.ndarray,
    dt: float,
    motion: Motion | None = None,
) -> PathArrays:
    """The path of a command, and of its ramp."""
    u = np.array(u, float)
    late = prompt_motion(len(u)) if motion is None else motion.arrays
    spare = spare_time(dt)
    return stopping_path(robot, late, np.array(q, float), u, dt, spare)


def at(path: PathArrays, times: np.ndarray) -> np.ndarray:
    """Configurations on a path, shape (k, n_q)."""
    return places(path, np.array(times, float))


def knots(path: PathArrays) -> np.ndarray:
    """Configurations where pieces begin, and the last, (s + 1, n_q)."""
    return np.concatenate([path.starts, at(path, path.times[-1:])])


def spans(path: PathArrays) -> np.ndarray:
    """How long the pieces last, shape (s,) [s]."""
    return np.diff(np.append(path.since, path.times[-1]))


def tube_of(robot: RobotModel, path: PathArrays) -> np.ndarray:
    """How far spheres may be off a path, shape (n,) [m]."""
    return robot.sphere_tube(path.tube, path.peak)


class Verdict(NamedTuple):
    """The command that may be applied, its fraction, and what objects."""

    command: np.ndarray
    scale: float
    objection: str


def verified_command(
    around: Around,
    u: np.ndarray,
    u_previous: np.ndarray,
    periods: float = 1.0,
) -> Verdict:
    """Finds the command closest to u that may be applied.

    The command before was sent some periods ago.
    """
    age, limit = periods * around.dt, around.limit
    own = around.self_clearance or SelfClearance.make(around.robot, 0.0)
    kept = KeptArrays(
        around.dt,
        spare_time(around.dt),
        around.self_clearance is not None,
        own.arrays.values,
        own.stopping,
        around.separation,
    )
    motion = prompt_motion(around.robot.n_u)
    now = around.motion.time if around.motion is not None else 0.0
    with MapCalls(around.robot, around.field) as line:
        command, scale, number = _verify(
            Packed(kept),
            around.arrays,
            *map_for_kernels(around.field),
            line,
            around.movers.arrays,
            around.movers.age(now),
            motion if around.motion is None else around.motion.arrays,
            float(now),
            np.array(around.state.q, float),
            np.array(around.clearance, float),
            around.stopping,
            np.array(u, float),
            executed_command(u_previous, limit, around.dt, age),
            braking_command(u_previous, limit, age),
        )
    return Verdict(command, scale, OBJECTIONS[number])


@kernel
def _verify(
    kept,
    robot,
    compiled,
    off,
    line,
    movers,
    age,
    motion,
    now,
    q,
    clearance,
    stopping,
    u,
    u_previous,
    ramp,
):
    around = surroundings(
        robot,
        (compiled, off, line),
        aged(movers, age),
        motion,
        now,
        state_arrays(robot, q),
        clearance,
        stopping,
        u,
        u_previous,
    )
    return verified(kept, around, u, ramp)
