"""Finds the greatest feasible fraction of the retreats that rows demand.

Rows with negative right-hand sides demand a retreat. If the demands are not
feasible together, all of them are multiplied by the same factor, the share. The
share is as large as the other rows and the bounds allow.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL
from remosplat_drake.controller.program.active_set import (
    INFEASIBLE,
    OPTIMAL,
    solve_dense,
)
from remosplat_drake.controller.program.kernels.dense import prune

_PRICE = 1e-8
"""Weight of the squared command, relative to the weight of the share. It makes
the program strictly convex."""

_TAKEN = 0.9
"""Fraction of the result of `greatest_share` that is used. A relaxed row
demands its original retreat times this result times this fraction. With a
fraction of 1, only a single command would be feasible, and successive commands
would jump between vertices of the feasible set."""


@kernel(returns=REAL)
def greatest_share(program) -> float:
    """Finds the largest feasible share of the retreats that rows demand.

    Let R be the relaxed rows. The share is the largest s in [0, 1] for which a
    command u within the bounds keeps

        a_i u <= s b_i for the rows i in R, all with b_i < 0 a_i u <= b_i for
        all other rows

    Args:
        program: The `ProgramArrays`, with the relaxed rows marked in `raised`.

    Returns:
        The share; negative if no command is feasible even for s = 0.
    """
    n, count = len(program.lower), program.count[0]
    H, c = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    for j in range(n):
        H[j, j] = _PRICE
    H[n, n], c[n] = 1.0, -1.0
    A, b = np.zeros((2 * n + 2 + count, n + 1)), np.zeros(2 * n + 2 + count)
    for j in range(n):
        A[j, j], b[j] = 1.0, program.upper[j]
        A[n + j, j], b[n + j] = -1.0, -program.lower[j]
    A[2 * n, n], b[2 * n] = 1.0, 1.0
    A[2 * n + 1, n] = -1.0
    row = 2 * n + 2
    for i in range(count):
        if not program.kept[i]:
            continue
        for j in range(n):
            A[row, j] = program.A[i, j]
        if program.raised[i]:
            A[row, n] = -program.b[i]
        else:
            b[row] = program.b[i]
        row += 1
    found, _, ended = solve_dense(H, c, A[:row], b[:row])
    if ended == INFEASIBLE:
        return -1.0
    return min(max(found[n], 0.0), 1.0) if ended == OPTIMAL else 0.0


@helper
def ease(program, share) -> None:
    """Multiplies the demands of relaxed rows by a share.

    Args:
        program: The `ProgramArrays`.
        share: The result of `greatest_share`.
    """
    for i in range(program.count[0]):
        if program.raised[i]:
            program.b[i] *= _TAKEN * share
    prune(program)
