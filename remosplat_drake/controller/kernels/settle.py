"""A whole tick in one compiled call: its program, decision, verification."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.binding import TIGHT
from remosplat_drake.controller.ingredients import CollisionDamper
from remosplat_drake.controller.kernels.assemble import (
    PARTS,
    Parts,
    assemble,
)
from remosplat_drake.controller.kernels.binding_arrays import binding_arrays
from remosplat_drake.controller.kernels.decide import (
    BRAKING,
    NOT_DECIDED,
    decide,
)
from remosplat_drake.controller.kernels.tick_arrays import (
    NearQuestion,
    given_or,
)
from remosplat_drake.controller.verification.kernels.verified import (
    least_clearances,
    verified,
)
from remosplat_drake.controller.verification.self_sweep import OwnArrays
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import aged

_SCENE = PARTS.index(CollisionDamper)


class LoopArrays(NamedTuple):
    """A law, as kernels take it that run its whole loop.

    Attributes:
        parts: Its ingredients.
        dt: Control period [s].
        strict: Whether every command keeps to the acceleration bounds.
        influence: Influence distance of the scene [m].
        stopping: Stopping distance from the scene [m].
        verify: Whether commands are verified.
        verify_own: Whether verification looks at the robot's own shapes, too.
        near: Where to look whether links are near each other.
        own: `SelfClearance.arrays`.
        own_stopping: The distance that its pairs keep [m].
        separation: The distance that is kept from where movers can be [m].
    """

    parts: Parts
    dt: float
    strict: bool
    influence: float
    stopping: float
    verify: bool
    verify_own: bool
    near: NearQuestion
    own: OwnArrays
    own_stopping: float
    separation: float


class Settled(NamedTuple):
    """What kernels find out in a tick; see `TickReport`.

    Attributes:
        command: The command that may be applied, shape (n_u,).
        status: Number of its status in `tick_report.STATUSES`; NOT_DECIDED
            where the tick must be found another way.
        scale: `TickReport.scale`.
        objection: Number of the objection in `verified.OBJECTIONS`.
        kept: `TickReport.kept`.
        binding: What `binding_arrays` returns.
        yielded: Of each row that yielded the number of its ingredient, and
            what it is about, shape (y, 2).
    """

    command: np.ndarray
    status: int
    scale: float
    objection: int
    kept: np.ndarray
    binding: tuple[np.ndarray, np.ndarray, np.ndarray]
    yielded: np.ndarray


@kernel
def settle_tick(
    law,
    robot,
    compiled,
    off,
    movers,
    age,
    aim,
    rows,
    q,
    u_previous,
    guidance,
):
    """Runs a tick of a robot that obeys at once, as `run_tick` does.

    Args:
        law: The `LoopArrays`.
        robot: The `RobotArrays`.
        compiled: The map, as `DistanceField.compiled`; it is 1-Lipschitz.
        off: Its `Misplacement`.
        movers: The `MoverArrays`.
        age: How old what is known of the movers is [s].
        aim: The `AimArrays`.
        rows: Spheres, distances and directions of the m clearances.
        q: Configuration, shape (n_q,) [rad, m].
        u_previous: The command that is being executed, shape (n_u,).
        guidance: The `GuidanceArrays`.

    Returns:
        The values of `Settled`.
    """
    state = state_arrays(robot, q)
    given = robot, compiled, off, state, rows, aged(movers, age)
    program, u, status, verdict = settle(law, given, aim, u_previous, guidance)
    command, scale, objection = verdict
    kept, yielded = np.zeros(len(rows[0]), np.bool_), _yielded(program)
    first, last = program.rows[_SCENE]
    if status != BRAKING:
        for i in range(first, last):
            kept[i - first] = program.kept[i]
        binding = binding_arrays(program, u, TIGHT)
    else:
        binding = np.empty((0, 3), np.int64), np.empty((0, 0)), np.empty(0)
    return command, status, scale, objection, kept, binding, yielded


@kernel
def verify_tick(
    law,
    robot,
    compiled,
    off,
    movers,
    age,
    q,
    sphere,
    distance,
    stopping,
    u,
    u_previous,
):
    """Verifies a command of a robot that obeys at once.

    Args:
        law: The `LoopArrays`.
        robot: The `RobotArrays`.
        compiled: The map, as `DistanceField.compiled`; it is 1-Lipschitz.
        off: Its `Misplacement`.
        movers: The `MoverArrays`.
        age: How old what is known of the movers is [s].
        q: Configuration, shape (n_q,) [rad, m].
        sphere: The sphere of each of m clearances, shape (m,).
        distance: The clearances, shape (m,) [m].
        stopping: Stopping distance that spheres keep from the scene [m].
        u: The wanted command, shape (n_u,).
        u_previous: The command that is being executed, shape (n_u,).

    Returns:
        What `verified` does.
    """
    n, state = len(robot.radius), state_arrays(robot, q)
    clearance = least_clearances(sphere, distance, n, law.influence)
    known = aged(movers, age)
    around = robot, compiled, off, known, state, clearance, stopping
    return verified(law, around, u, u_previous)


@helper
def settle(law, given, aim, u_previous, guidance):
    """Builds the program of a tick, decides, and verifies what is decided.

    Args:
        law: The `LoopArrays`.
        given: The `RobotArrays`, the compiled map, its `Misplacement`, the
            `StateArrays`, the rows of the clearances, and the `MoverArrays`.
        aim: The `AimArrays`.
        u_previous: The command that is being executed, shape (n_u,).
        guidance: The `GuidanceArrays`.

    Returns:
        The `ProgramArrays`, what `decide` returns of them, and in a tuple what
        `verified` does.
    """
    robot, compiled, off, state, rows, movers = given
    program = assemble(
        law.parts,
        robot,
        state,
        aim,
        rows,
        movers,
        law.near,
        u_previous,
        law.dt,
        np.zeros(len(robot.radius)),
        guidance,
    )
    u, status = decide(program, robot, u_previous, law.dt, law.strict)
    if status == NOT_DECIDED or not law.verify:
        return program, u, status, (u, 1.0, 0)
    n, stopping = len(robot.radius), given_or(guidance.stopping, law.stopping)
    clearance = least_clearances(rows[0], rows[1], n, law.influence)
    around = robot, compiled, off, movers, state, clearance, stopping
    return program, u, status, verified(law, around, u, u_previous)


@helper
def _yielded(program):
    """Finds the rows that yielded, ingredient by ingredient."""
    found, count = np.empty((program.count[0], 2), np.int64), 0
    for part in range(len(program.rows)):
        for i in range(program.rows[part, 0], program.rows[part, 1]):
            if program.raised[i]:
                found[count, 0], found[count, 1] = part, program.about[i]
                count += 1
    return found[:count]
