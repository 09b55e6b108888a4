"""Decides on the command of a tick: solves its program, with fallbacks."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, reals, several
from remosplat_drake.base.python_calls import call_python
from remosplat_drake.controller.ingredients import (
    CollisionDamper,
    JointLimitDamper,
    MoverDamper,
    SelfCollisionDamper,
)
from remosplat_drake.controller.ingredients.kernels.assemble import (
    OUTSIDE,
    PARTS,
    YIELD_ORDER,
)
from remosplat_drake.controller.program.active_set import OPTIMAL, UNDECIDED
from remosplat_drake.controller.program.kernels.compiled_terms import NO_PART
from remosplat_drake.controller.program.kernels.dense import (
    prune,
    slack_form,
    solve_program,
    span,
)
from remosplat_drake.controller.tick.kernels.share import ease, greatest_share
from remosplat_drake.signals.tick_report import STATUSES

SOLVE = 3
"""Index of the Python function that solves quadratic programs."""

_WHOLE, _DROPPED, _RELAXED, BRAKING = range(len(STATUSES))
"""Numbers of the statuses in `tick_report.STATUSES`."""

_GENTLE_ORDER = YIELD_ORDER[1:]
"""Ingredients whose rows are relaxed before acceleration bounds are dropped,
since a retreat from obstacles at rest need not be sudden."""

_OF_ALONE = 0.5
"""Largest speed of retreat that a relaxed row demands, as a fraction of the
fastest retreat that would be possible without other rows. So a link that can
hardly move does not limit the retreat of other links."""

_TASK = 1e-3
"""Factor of the weights of slack and of linear costs while rows of
`_GENTLE_ORDER` are relaxed. The factor is small, since motion for other
purposes would curve the retreat, and verification rejects curved retreats."""

_NOTABLE = 2e-3
"""Demanded speed of retreat from which on an obstacle counts as too near [m/s].
With the default settings, a sphere whose clearance is a millimetre less than
the stopping distance has this speed."""

_DEMANDED = 1e-8
"""Demanded speed of retreat [m/s]. If verification rejects a command, and the
demanded speed is at least this value, the robot retreats instead of moving to
its target. The value is slightly larger than rounding errors."""

_CRAWL = 0.25
"""Factor of the command. If a robot is too near to an obstacle, and
verification scales its command by less than this factor, the robot retreats
instead of moving to its target."""

_SELF, _SCENE, _MOVERS, _JOINTS = map(
    PARTS.index,
    (SelfCollisionDamper, CollisionDamper, MoverDamper, JointLimitDamper),
)


@kernel(returns=several(reals(1), WHOLE))
def decide(program, ramp, strict, is_own_solver, line):
    """Solves the program of a tick, with fallbacks if it has no optimum.

    The following programs are tried in this order until one has an optimum: the
    program without changes; the program in which rows that demand a retreat are
    relaxed in `_GENTLE_ORDER`; the program without acceleration bounds; and the
    program without acceleration bounds in which rows are relaxed in
    `YIELD_ORDER`. If none has an optimum, the command is a step of the braking
    ramp. All relaxed rows demand the same fraction of their retreats, which is
    as large as feasible; see `greatest_share`. If the law is strict,
    acceleration bounds are never dropped. Verification, including that of the
    joint limits, is never relaxed.

    Args:
        program: The `ProgramArrays`, which fallbacks change.
        ramp: The braking ramp's next step, shape (n_u,).
        strict: Whether every command must keep the acceleration bounds.
        is_own_solver: Whether the library's own solver is used.
        line: Number of the `PythonCalls`.

    Returns:
        The command, shape (n_u,), and the number of its status in
        `tick_report.STATUSES`.
    """
    u, is_found = _optimum(program, is_own_solver, line)
    if is_found:
        return u, _WHOLE
    if program.count[2]:
        u, is_found = _eased(program, _GENTLE_ORDER, _TASK, is_own_solver, line)
        if is_found:
            return u, _RELAXED
        if not strict:
            for j in range(len(u)):
                program.lower[j] = program.free_lower[j]
                program.upper[j] = program.free_upper[j]
            prune(program)
            u, is_found = _optimum(program, is_own_solver, line)
            if is_found:
                return u, _DROPPED
    u, is_found = _eased(program, YIELD_ORDER, 1.0, is_own_solver, line)
    if is_found:
        return u, _RELAXED
    return ramp, BRAKING


@helper
def demanded_retreat(program):
    """Finds the fastest retreat that rows demand [m/s, rad/s]; 0 for none.

    Args:
        program: The `ProgramArrays`, before `decide`.
    """
    most = 0.0
    for k in (_SELF, _SCENE, _MOVERS, _JOINTS):
        for i in range(program.rows[k, 0], program.rows[k, 1]):
            most = max(most, -program.b[i])
    return most


@helper
def should_retreat(scale, retreat):
    """Returns whether a robot too near to an obstacle should only retreat.

    Additional motion towards the target would curve the retreat, and
    verification might reject the command at every tick.

    Args:
        scale: The factor of the command that verification has allowed.
        retreat: The result of `demanded_retreat` [m/s, rad/s].
    """
    if scale == 0.0:
        return retreat > _DEMANDED
    return scale < _CRAWL and retreat > _NOTABLE


@helper
def least_retreat(program, is_own_solver, line):
    """Finds the smallest command that satisfies all rows.

    Args:
        program: The `ProgramArrays`, which `decide` has solved. This function
            sets their linear costs and tracked twists to zero.
        is_own_solver: Whether the library's own solver is used.
        line: Number of the `PythonCalls`.

    Returns:
        The command, shape (n_u,), and whether such a command exists.
    """
    program.linear[:] = 0.0
    program.V[:] = 0.0
    return _optimum(program, is_own_solver, line)


@helper
def _eased(program, order, task, is_own_solver, line):
    """Finds the optimum with relaxed rows; relaxes one class after the other.

    The weights of slack and linear costs are multiplied by `task`. If there is
    no optimum, the program is unchanged.
    """
    demanded, price = program.b.copy(), program.price.copy()
    linear = program.linear.copy()
    for k in order:
        yields = _let_yield(program, k)
        if k == YIELD_ORDER[-1]:
            for other in range(OUTSIDE, len(program.rows)):
                yields |= _let_yield(program, other)
        if not yields:
            continue
        share = greatest_share(program)
        if share < 0.0:
            continue
        eased = program.b.copy()
        ease(program, share)
        program.price[:] = task * price
        program.linear[:] = task * linear
        u, is_found = _optimum(program, is_own_solver, line)
        if is_found:
            return u, True
        program.b[:] = eased
    program.b[:], program.price[:] = demanded, price
    program.linear[:] = linear
    program.raised[:] = False
    prune(program)
    return np.zeros(len(program.lower)), False


@helper
def _optimum(program, is_own_solver, line):
    """Finds the optimum of a program, and returns whether there is one.

    If the library's own solver is undecided because of rounding errors, or if
    Drake's program has further terms, Python solves the program.
    """
    if program.count[4]:
        return np.zeros(len(program.lower)), False
    u, ended = np.zeros(len(program.lower)), UNDECIDED
    if is_own_solver and not program.count[5]:
        u, ended = solve_program(program)
    if ended == UNDECIDED:
        u = np.zeros(len(program.lower))
        form = slack_form(program)
        ended = call_python(line, SOLVE, (u, *form))
    return u, ended == OPTIMAL and np.isfinite(u).all()


@helper
def _let_yield(program, k):
    """Marks those rows of ingredient k as relaxed that demand a retreat.

    The demand of each row is limited to a value that is feasible without other
    rows.
    """
    yields = False
    for i in range(program.rows[k, 0], program.rows[k, 1]):
        if program.b[i] < 0.0:
            least, _ = span(program, program.A[i])
            program.b[i] = max(program.b[i], _OF_ALONE * min(least, 0.0))
            program.raised[i] = yields = True
    return yields


@helper
def nearest_inside(program):
    """Finds the deepest violation of a stopping distance.

    Args:
        program: The `ProgramArrays`, before `decide`.

    Returns:
        The number of the ingredient whose row demands the fastest retreat, the
        index of this row among the rows of the ingredient, and the row's
        subject. The number is NO_PART if no violation exceeds rounding errors.
    """
    part, index, about, most = NO_PART, 0, 0, -_NOTABLE
    for k in (_SELF, _SCENE):
        first, last = program.rows[k]
        for i in range(first, last):
            if program.b[i] < most:
                part, index = k, i - first
                about, most = program.about[i], program.b[i]
    return part, index, about
