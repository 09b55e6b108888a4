"""Verify-then-scale: every command leaves a way to stop that the map allows.

The program's damper rows are linear in u and hold where the tick starts.
Before a command is applied, the states that follow are checked against the
map itself: the one at the end of the tick, and those along the braking ramp
from there to a standstill.

The guarantee. Let d_0 be a sphere's clearance when control starts. Then its
clearance at the end of every tick is at least min(d_s, d_0), where d_s is the
smallest stopping distance used, if

- the scene does not move and the map is the truth (what the map misses is
  not seen here either),
- the robot executes commands exactly, each for one control period, and
- the arithmetic is exact (it is so to about 1e-14 m).

Between tick ends nothing is checked. Proof: when a command is applied, its
braking ramp has been checked, at a level not below min(d_s, d_0); the next
tick either finds a better command whose ramp passes the check, or takes the
first step of the ramp that has passed it already.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.oracle.distance_field import DistanceField
from remosplat_drake.robot.robot_model import RobotModel, RobotState
from remosplat_drake.safety.braking import braking_command, braking_fractions

SCALES = (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Fractions of the way from braking to the command that are tried."""


@dc.dataclass(frozen=True, eq=False)
class Surroundings:
    """What verification knows of the present tick.

    Attributes:
        robot: Predicts states.
        field: The map.
        state: Kinematics at the present configuration.
        clearance: Present clearance of each sphere, or a lower bound of it
            that is at least d_s, shape (n,) [m].
        stopping: d_s [m].
        dt: Control period [s].
        acceleration_limit: Bounds on |du/dt|; infinite where the robot may
            stop at once, shape (n_u,).
    """

    robot: RobotModel
    field: DistanceField
    state: RobotState
    clearance: np.ndarray
    stopping: float
    dt: float
    acceleration_limit: np.ndarray


def verified_command(
    around: Surroundings, u: np.ndarray, u_previous: np.ndarray
) -> tuple[np.ndarray, float]:
    """The command closest to u, towards braking, that may be applied.

    Commands on the way from the braking ramp's next step (fraction 0) to u
    (fraction 1) are tried; all of them respect the acceleration bounds if u
    does. One passes if at the end of the tick, and of every tick of its own
    braking ramp, each sphere is at least min(d_s, its present clearance)
    from the scene. There is no tolerance, which would let the clearance
    creep down tick by tick. Fraction 0 needs no check: it was checked when
    the command being executed was.

    Args:
        around: Robot, map and present state.
        u: The wanted command, shape (n_u,).
        u_previous: The command being executed, shape (n_u,).

    Returns:
        The command and its fraction.
    """
    brake = braking_command(u_previous, around.acceleration_limit, around.dt)
    for scale in SCALES:
        command = u if scale == 1.0 else brake + scale * (u - brake)
        if _survives(around, command):
            return command, scale
    return brake, 0.0


def _survives(around: Surroundings, u: np.ndarray) -> bool:
    """Whether every state of this tick and its braking ramp is allowed."""
    robot, field, dt = around.robot, around.field, around.dt
    floor = np.minimum(around.stopping, around.clearance)
    ramp = braking_fractions(u, around.acceleration_limit, dt)
    fractions = np.concatenate([[1.0], ramp])
    near = np.arange(len(floor))
    room = np.full(len(floor), -1.0)
    if field.is_lipschitz:
        room = around.clearance - floor
        travel = robot.reach @ np.abs(u) * (fractions.sum() * dt)
        near = np.flatnonzero(travel >= room)
        if not len(near):
            return True
    states = robot.advance_along(around.state.q, u, fractions, dt)
    asked, sphere = robot.moved_spheres(
        states, near, around.state.spheres.p_WS[near], room[near]
    )
    if not len(asked):
        return True
    level = floor[sphere]
    found = field.clearances(asked, np.nextafter(level.max(), np.inf))
    return bool((found.per_sphere(len(asked)) >= level).all())
