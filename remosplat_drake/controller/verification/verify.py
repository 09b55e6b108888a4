"""Verify-then-scale: every command leaves a way to stop that the map allows.

The program's damper rows are linear in u and hold where the tick starts.
Before a command is applied, the path that follows is checked: one tick of the
command and its braking ramp to a standstill. The supervisor's ramp is the
same one.

The guarantee. Let d_0 be a distance when control starts: a sphere's clearance
of the scene, or the distance of two of the robot's convex shapes. Let d_s be
the smallest stopping distance used. Then

- at the end of every tick the distance is at least min(d_s, d_0),
- at all times it is at least min(d_s, d_0) - `TOLERANCE`, and
- no joint is ever beyond its limits, or farther than it was at the start,

if

- the scene does not move and the map is the truth (what the map misses is
  not seen here either),
- the robot executes commands exactly, each for one control period, and
- the arithmetic is exact (it is so to about 1e-14 m).

A map that is not Lipschitz, such as depth views, allows less: its own answer
at the end of every tick, and nothing about the time between.

What moves is kept off, too (`kernels/mover_sweep.py`). While a sphere moves,
it is not touched by a mover that keeps its bounds, or it moves away from it,
and that by all that is said above; a sphere at rest may be. Nothing tells a
mover from the robot's own parts, or promises that perception sees it: no
conformity to a standard is claimed. The distance that is kept is put together
as the protective separation distance of ISO/TS 15066: the mover's way and the
robot's until it stands, both their uncertainties, and the separation itself.

Proof: when a command is applied, its path has been checked, at a level not
below min(d_s, d_0); the next tick either finds a better command whose path
passes the check, or takes the first step of the ramp that has passed it
already. Where movers can be is foreseen for the whole of a path, and so it was
foreseen where they are later: the rest of a ramp stays checked.
"""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

from remosplat_drake.controller.braking import braking_command
from remosplat_drake.controller.verification.kernels.map_sweep import (
    keeps_joint_limits,
)
from remosplat_drake.controller.verification.kernels.mover_sweep import (
    keeps_off_movers,
)
from remosplat_drake.controller.verification.kernels.verified import (
    SCALES,
    TOLERANCE,
)
from remosplat_drake.controller.verification.scene_sweep import (
    keeps_off_the_scene,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.controller.verification.stopping_path import StoppingPath
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.scene.mover import MoverArrays
from remosplat_drake.signals.binding import (
    COLLISION,
    JOINT_LIMIT,
    MOVER,
    SELF_COLLISION,
)
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion import Motion


@dc.dataclass(frozen=True, eq=False)
class Surroundings:
    """What verification knows of the present tick.

    Attributes:
        robot: The robot, whose kinematics predict configurations.
        field: The map.
        state: Kinematics at the present configuration.
        clearance: Present clearance of each sphere, or a lower bound of it
            that is at least d_s, shape (n,) [m].
        stopping: Stopping distance d_s that spheres keep from the scene [m].
        dt: Control period [s].
        acceleration_limit: Bounds on |du/dt| of the braking ramp; infinite
            where the robot may stop at once, shape (n_u,).
        self_clearance: Distances that the robot's own parts keep from each
            other; None if these are not checked.
        motion: What the robot is about to do already; None where it obeys at
            once. The state is then that in which a command begins to act.
        movers: What moves, as it is known when a path starts; None if nothing
            does.
        separation: Distance that spheres which move keep from wherever movers
            can be [m].
    """

    robot: RobotModel
    field: DistanceField
    state: RobotState
    clearance: np.ndarray
    stopping: float
    dt: float
    acceleration_limit: np.ndarray
    self_clearance: SelfClearance | None = None
    motion: Motion | None = None
    movers: MoverArrays | None = None
    separation: float = 0.0

    def path(self, u: np.ndarray) -> StoppingPath:
        """Makes the path of a command and of its ramp."""
        limit = self.acceleration_limit
        if self.motion is not None:
            return StoppingPath.through(
                self.robot, self.motion, u, limit, self.dt
            )
        return StoppingPath.make(self.robot, self.state.q, u, limit, self.dt)


class Verdict(NamedTuple):
    """What verification makes of a command.

    Attributes:
        command: The command that may be applied, shape (n_u,).
        scale: Its fraction: one of `SCALES`, or 0 for braking.
        objection: What stood against the whole command, as `objection` says
            it; empty if nothing did.
    """

    command: np.ndarray
    scale: float
    objection: str = ""


def verified_command(
    around: Surroundings, u: np.ndarray, u_previous: np.ndarray
) -> Verdict:
    """Finds the command closest to u, towards braking, that may be applied.

    Commands on the way from the braking ramp's next step (fraction 0) to u
    (fraction 1) are tried; all of them respect the acceleration bounds if u
    does. One passes if on its path each sphere stays at least min(d_s, its
    present clearance) from the scene, the robot's shapes in the same way
    from each other, and each joint within its limits. At the ends of ticks
    there is no tolerance, which would let distances creep down tick by tick.
    Fraction 0 needs no check: it was checked when the command being executed
    was.

    Args:
        around: Robot, map and present state.
        u: The wanted command, shape (n_u,) [rad/s, m/s].
        u_previous: The command being executed, shape (n_u,) [rad/s, m/s].

    Returns:
        The command that may be applied, its fraction, and what stood against
        the whole of u.
    """
    brake = braking_command(u_previous, around.acceleration_limit, around.dt)
    first = ""
    for scale in SCALES:
        command = u if scale == 1.0 else brake + scale * (u - brake)
        found = objection(around, command)
        if not found:
            return Verdict(command, scale, first)
        first = first or found
    return Verdict(brake, 0.0, first)


def can_stop(around: Surroundings, u: np.ndarray) -> bool:
    """Tells whether the path of a command, and of its ramp, is allowed.

    Args:
        around: Robot, map and present state.
        u: The command, shape (n_u,) [rad/s, m/s].
    """
    return not objection(around, u)


def objection(around: Surroundings, u: np.ndarray) -> str:
    """Says what the path of a command, or of its ramp, comes too near to.

    Args:
        around: Robot, map and present state.
        u: The command, shape (n_u,) [rad/s, m/s].

    Returns:
        What `path_objection` says of the path.
    """
    return path_objection(around, around.path(u))


def path_objection(around: Surroundings, path: StoppingPath) -> str:
    """Says what a path comes too near to.

    Args:
        around: Robot, map and the state at which the path starts.
        path: The path.

    Returns:
        `JOINT_LIMIT`, `SELF_COLLISION`, `MOVER` or `COLLISION`; empty if the
        path is allowed.
    """
    lower, upper = path.robot.position_lower, path.robot.position_upper
    if not keeps_joint_limits(path.arrays, lower, upper):
        return JOINT_LIMIT
    if not _keeps_off_itself(around, path):
        return SELF_COLLISION
    tube = path.sphere_tube()
    if not _keeps_off_movers(around, path, tube):
        return MOVER
    stopping = around.stopping + tube
    keeps_off = keeps_off_the_scene(
        path,
        around.field,
        around.state.spheres.p_WS,
        around.clearance,
        np.minimum(stopping, around.clearance),
        TOLERANCE,
    )
    return "" if keeps_off else COLLISION


def _keeps_off_itself(around: Surroundings, path: StoppingPath) -> bool:
    if around.self_clearance is None:
        return True
    return around.self_clearance.is_kept(path, TOLERANCE)


def _keeps_off_movers(
    around: Surroundings, path: StoppingPath, tube: np.ndarray
) -> bool:
    if around.movers is None:
        return True
    return keeps_off_movers(
        path.robot.arrays,
        path.arrays,
        path.clock,
        around.movers,
        around.state.spheres.p_WS,
        around.separation,
        tube,
        TOLERANCE,
    )
