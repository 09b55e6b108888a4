"""Adds terms of ingredients in Python, for which kernels call Python."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.python_calls import FAILED, call_python, packed_at
from remosplat_drake.controller.program.kernels.dense import (
    prune,
    slack_form,
)
from remosplat_drake.controller.program.kernels.tick_arrays import (
    PROGRAM,
    OutsideArrays,
    ProgramArrays,
    make_program,
)

ADD = 2
"""Index of the Python function that returns the terms of such ingredients."""


@helper
def add_outside(like, line, program, inputs):
    """Calls ingredients in Python, which add to the program of a tick.

    Args:
        like: A packed `OutsideRows` of the same type as the ingredients' rows.
        line: Number of the `PythonCalls`.
        program: The `ProgramArrays`.
        inputs: Further inputs of the ingredients: the `StateArrays`, the
            command that is being executed, the `RowArrays` of the clearances,
            and the time since the first tick of the rollout [s].

    Returns:
        The `ProgramArrays` with the added terms, and True. If a term is
        invalid, the `ProgramArrays` without these terms, and False.
    """
    n_u = len(program.lower)
    bounds, costs = np.empty((4, n_u)), np.zeros((2, n_u))
    flags = np.zeros(2, np.bool_)
    for j in range(n_u):
        bounds[0, j], bounds[1, j] = program.lower[j], program.upper[j]
        bounds[2, j] = program.free_lower[j]
        bounds[3, j] = program.free_upper[j]
    address = call_python(line, ADD, (bounds, costs, flags, *inputs))
    if address == FAILED:
        return program, False
    more = packed_at(like, address)
    return joined(program, OutsideArrays(bounds, costs, flags, more)), True


@kernel(returns=PROGRAM)
def joined(program, outside) -> ProgramArrays:
    """Appends the terms of ingredients in Python to a program.

    Args:
        program: The `ProgramArrays`, whose terms are copied.
        outside: The `OutsideArrays`.
    """
    k, n_u = len(program.rows) - 1, len(program.lower)
    rows, tracked = outside.more.rows, outside.more.tracked
    m, more = program.count[0], len(rows)
    A, b = np.empty((m + more, n_u)), np.empty(m + more)
    about = np.empty(m + more, np.int64)
    for i in range(m + more):
        about[i] = program.about[i] if i < m else i - m
        b[i] = program.b[i] if i < m else rows[i - m, n_u]
        for j in range(n_u):
            A[i, j] = program.A[i, j] if i < m else rows[i - m, j]
    r, further = program.count[3], len(tracked)
    J, V = np.empty((r + further, n_u)), np.empty(r + further)
    limit, price = np.empty(r + further), np.empty(r + further)
    for i in range(r):
        V[i], limit[i] = program.V[i], program.limit[i]
        price[i] = program.price[i]
        for j in range(n_u):
            J[i, j] = program.J[i, j]
    for i in range(further):
        row = tracked[i]
        V[r + i], limit[r + i], price[r + i] = row[n_u], row[n_u + 1], row[-1]
        for j in range(n_u):
            J[r + i, j] = row[j]
    for j in range(n_u):
        program.linear[k, j] = outside.costs[0, j]
        program.quadratic[k, j] = outside.costs[1, j]
    program.has[k, 0] = program.has[k, 1] = True
    program.rows[k, 0], program.rows[k, 1] = m, m + more
    program.count[0], program.count[3] = m + more, r + further
    if outside.flags[0]:
        program.count[2] = 1
    if outside.flags[1]:
        program.count[5] = 1
    whole = ProgramArrays(
        outside.bounds[0].copy(),
        outside.bounds[1].copy(),
        outside.bounds[2].copy(),
        outside.bounds[3].copy(),
        program.linear.copy(),
        program.quadratic.copy(),
        program.has.copy(),
        A,
        b,
        np.zeros(m + more, np.bool_),
        np.zeros(m + more, np.bool_),
        about,
        program.rows.copy(),
        J,
        V,
        limit,
        price,
        program.tracked.copy(),
        program.count.copy(),
    )
    prune(whole)
    return whole


@kernel
def slack_form_of_outside(outside):
    """Computes the `SlackForm` of the terms of ingredients in Python alone.

    Args:
        outside: The `OutsideArrays`.

    Returns:
        The ten arrays of a `SlackForm`.
    """
    nothing = make_program(outside.bounds[1].copy(), 0, 1, 0)
    return slack_form(joined(nothing, outside))
