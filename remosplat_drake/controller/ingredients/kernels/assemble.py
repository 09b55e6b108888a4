"""A kernel that assembles the quadratic program of a tick from ingredients."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, named
from remosplat_drake.controller.ingredients.active_collision_cost import (
    ActiveCollisionCost,
    add_active_collision_cost,
)
from remosplat_drake.controller.ingredients.base_orientation_cost import (
    BaseOrientationCost,
    add_base_orientation_cost,
)
from remosplat_drake.controller.ingredients.collision_damper import (
    CollisionDamper,
    add_collision_damper,
)
from remosplat_drake.controller.ingredients.joint_limit_damper import (
    JointLimitDamper,
    add_joint_limit_damper,
)
from remosplat_drake.controller.ingredients.manipulability_cost import (
    ManipulabilityCost,
    add_manipulability_cost,
)
from remosplat_drake.controller.ingredients.mover_damper import (
    MoverDamper,
    add_mover_damper,
)
from remosplat_drake.controller.ingredients.path_tracking import (
    PathTracking,
    add_path_tracking,
)
from remosplat_drake.controller.ingredients.self_collision_damper import (
    SelfCollisionDamper,
    add_self_collision_damper,
)
from remosplat_drake.controller.ingredients.servo_tracking import (
    ServoTracking,
    add_servo_tracking,
)
from remosplat_drake.controller.ingredients.velocity_cost import (
    VelocityCost,
    add_velocity_cost,
)
from remosplat_drake.controller.ingredients.velocity_limits import (
    VelocityLimits,
    add_velocity_limits,
)
from remosplat_drake.controller.program.kernels.compiled_terms import (
    NO_PART,
    AddedBy,
    add_compiled,
)
from remosplat_drake.controller.program.kernels.dense import prune
from remosplat_drake.controller.program.kernels.tick_arrays import (
    PROGRAM,
    ProgramArrays,
    find_movers,
    make_program,
    make_tick,
    near_arrays,
)
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import aged

KINDS = (
    (ServoTracking, add_servo_tracking),
    (VelocityCost, add_velocity_cost),
    (VelocityLimits, add_velocity_limits),
    (JointLimitDamper, add_joint_limit_damper),
    (CollisionDamper, add_collision_damper),
    (SelfCollisionDamper, add_self_collision_damper),
    (ActiveCollisionCost, add_active_collision_cost),
    (ManipulabilityCost, add_manipulability_cost),
    (BaseOrientationCost, add_base_orientation_cost),
    (PathTracking, add_path_tracking),
    (MoverDamper, add_mover_damper),
)
"""The library's classes of ingredients, and the function that adds the terms of
each class. The functions are called in this order."""

PARTS = tuple(kind for kind, _ in KINDS)
"""The library's classes of ingredients. The number of an ingredient is the
index of its class."""

OUTSIDE = len(PARTS)
"""Number of a user's first ingredient. Each compiled ingredient has its own
number, and all ingredients in Python share the last number.
"""

YIELD_ORDER = tuple(
    PARTS.index(kind)
    for kind in (
        MoverDamper,
        JointLimitDamper,
        SelfCollisionDamper,
        CollisionDamper,
    )
)
"""Classes of ingredients whose rows are relaxed if the program is infeasible,
in this order.

Rows of a user's ingredients are relaxed together with those of the last class.
"""


class Parts(NamedTuple):
    """The compiled ingredients of a control law.

    Attributes:
        settings: Inputs of the functions, in the order of `KINDS`.
        present: Whether the law has each of the k classes, shape (k,), bool.
        added_by: The functions of a user's compiled ingredients.
    """

    settings: tuple
    present: np.ndarray
    added_by: AddedBy


class Assembled(NamedTuple):
    """The program of a tick with the terms of the compiled ingredients.

    Attributes:
        program: The program. If an ingredient has invalid terms, the program
            must not be solved, and is only used for error messages.
        refused: Number of an ingredient with invalid terms, or NO_PART.
        ended: Result of the call of that ingredient's function.
    """

    program: ProgramArrays
    refused: int
    ended: int


def in_turn(adders: Sequence[Callable]) -> Callable:
    """Makes a function that calls the functions of a law's ingredients.

    The source of this function is generated, with one line for each class,
    since Numba cannot loop over functions. Compiling a chain of functions that
    call each other would take nearly three times as long.

    Args:
        adders: The functions, in the order of `KINDS`.
    """
    lines = (
        f"    if parts.present[{k}]:"
        f" add_{k}(parts.settings[{k}], {k}, tick, program)\n"
        for k in range(len(adders))
    )
    names: dict[str, Any] = {f"add_{k}": add for k, add in enumerate(adders)}
    names["__name__"] = __name__  # Numba identifies functions by module.
    exec("def add_all(parts, tick, program):\n" + "".join(lines), names)
    return helper(names["add_all"])


add_all = in_turn([add for _, add in KINDS])

_JOINTS, _ACTIVE, _MOVERS = (
    PARTS.index(kind)
    for kind in (JointLimitDamper, ActiveCollisionCost, MoverDamper)
)


@kernel(returns=named(Assembled, PROGRAM, WHOLE, WHOLE))
def assemble(
    parts,
    robot,
    state,
    aim,
    rows,
    movers,
    near,
    u_previous,
    dt,
    tube,
    guidance,
) -> Assembled:
    """Builds the quadratic program of a tick.

    Args:
        parts: The `Parts`.
        robot: The `RobotArrays`.
        state: The `StateArrays`.
        aim: The `AimArrays`.
        rows: Spheres, distances and directions of the m clearances.
        movers: The `MoverArrays`.
        near: The `NearSettings`: settings of the search for near links.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        tube: Bound of each sphere's deviation from its path, shape (n,) [m].
        guidance: The `GuidanceArrays`.
    """
    found = find_movers(
        movers,
        state.p_WS,
        robot.radius,
        parts.settings[_MOVERS].influence,
        dt,
        parts.settings[_ACTIVE].lead,
        parts.settings[_ACTIVE].mover_influence,
    )
    links = near_arrays(near, state.X_WL)
    tick = make_tick(
        robot, state, aim, rows, found, links, u_previous, dt, tube, guidance
    )
    most = len(rows[0]) + len(links.pair) + len(tick.moving.sphere)
    most += 2 * len(parts.settings[_JOINTS].gain) + parts.added_by.most.sum()
    n_parts = OUTSIDE + len(parts.added_by.most) + 1
    program = make_program(
        robot.velocity_limit, len(robot.body_E), n_parts, most
    )
    add_all(parts, tick, program)
    refused, ended = add_compiled(parts.added_by, OUTSIDE, tick, program)
    if refused == NO_PART:
        prune(program)
    return Assembled(program, refused, ended)


@kernel
def assemble_tick(
    parts,
    near,
    robot,
    movers,
    age,
    aim,
    rows,
    q,
    u_previous,
    dt,
    tube,
    guidance,
) -> Assembled:
    """Builds the quadratic program of a tick, for calls from Python.

    Args:
        parts: See `assemble`.
        near: See `assemble`.
        robot: See `assemble`.
        movers: The `MoverArrays` at their stamp.
        age: Age of the movers' measurements [s].
        aim: See `assemble`.
        rows: See `assemble`.
        q: The configuration, shape (n_q,) [rad, m].
        u_previous: See `assemble`.
        dt: See `assemble`.
        tube: See `assemble`.
        guidance: See `assemble`.
    """
    return assemble(
        parts,
        robot,
        state_arrays(robot, q),
        aim,
        rows,
        aged(movers, age),
        near,
        u_previous,
        dt,
        tube,
        guidance,
    )
