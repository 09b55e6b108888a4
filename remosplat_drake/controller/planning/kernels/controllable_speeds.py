"""Computes the greatest speeds with which the rest of a path is feasible.

The module also computes the greatest acceleration at each point of the path.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals, several

_NOTHING = 1e-9
"""Magnitude below which a coefficient counts as zero."""


@kernel(returns=several(reals(1), reals(2)))
def controllable_speeds(rate, bend, offset, bound, step, fastest):
    """Computes the greatest speeds with which the rest of a path is feasible.

    Let s be the arc length of a path, and v = ds/dt the speed. There are bounds
    of m quantities, such as accelerations and torques, which are linear in
    dv/dt and v^2:

        |r dv/dt + r' v^2 + o| <= b.

    A first pass goes from the end of the path to its start. For each node, it
    finds the greatest v^2 from which some dv/dt within these bounds leads to a
    feasible v^2 at the next node. A second pass, from the start to the end,
    limits v^2 to values that are reachable from the previous node (reachability
    analysis; Pham and Pham 2018). Each step of a pass is a linear program in
    one or two variables. Since a robot at rest keeps all bounds, the solution
    is the least of a few quotients.

    At the path's end, the speed is 0. The greatest feasible dv/dt is a concave
    function of v^2. So at a lower speed it is at least the linear interpolation
    between its values at rest and at the greatest speed.

    Args:
        rate: r on each of the k pieces between the nodes, shape (k, m).
        bend: r' at all nodes except the last, shape (k, m).
        offset: o at these nodes, with |o| <= b, shape (k, m).
        bound: The bounds b, shape (m,).
        step: Arc length from each node to the next, shape (k,).
        fastest: Bounds of the speed at these nodes, shape (k,) [1/s].

    Returns:
        The speeds at all nodes, shape (k + 1,) [1/s], and the greatest dv/dt
        for a robot at rest and for a robot at these speeds, shape (k + 1, 2)
        [1/s^2].
    """
    k, m = rate.shape
    square, change = np.zeros(k + 1), np.zeros((k + 1, 2))
    # Upper and lower bounds of dv/dt are lines over v^2, each as offset and
    # slope.
    upper, lower = np.empty((m + 1, 2)), np.empty((m + 1, 2))
    for i in range(k - 1, -1, -1):
        terms = rate[i], bend[i], offset[i], bound
        count, most = _bound_lines(terms, upper, lower)
        # The speed at the next node must be feasible, too.
        upper[count, 0] = 0.5 * square[i + 1] / step[i]
        lower[count, 0] = 0.0
        upper[count, 1] = lower[count, 1] = -0.5 / step[i]
        most = min(most, fastest[i] ** 2)
        square[i] = _most_between(lower, upper, count + 1, most)
    for i in range(k):
        terms = rate[i], bend[i], offset[i], bound
        count, _ = _bound_lines(terms, upper, lower)
        change[i] = np.inf
        for line in range(count):
            at_speed = upper[line, 0] + upper[line, 1] * square[i]
            change[i, 0] = min(change[i, 0], upper[line, 0])
            change[i, 1] = min(change[i, 1], at_speed)
        reached = square[i] + 2.0 * step[i] * change[i, 1]
        square[i + 1] = min(square[i + 1], max(reached, 0.0))
    change[k] = change[k - 1]
    return np.sqrt(square), change


@helper
def _bound_lines(terms, upper, lower):
    """Writes the lines that bound dv/dt over v^2 at a node.

    Returns:
        The number of lines, and the greatest v^2 within the bounds that do not
        depend on dv/dt.
    """
    rate, bend, offset, bound = terms
    count, most = 0, np.inf
    for j in range(len(bound)):
        r, c = rate[j], bend[j]
        above, below = bound[j] - offset[j], -bound[j] - offset[j]
        if r < 0.0:
            above, below = below, above
        if abs(r) > _NOTHING:
            upper[count, 0], lower[count, 0] = above / r, below / r
            upper[count, 1] = lower[count, 1] = -c / r
            count += 1
        elif abs(c) > _NOTHING:
            most = min(most, max(above / c, below / c))
    return count, most


@helper
def _most_between(lower, upper, count, most):
    """Returns the largest x <= `most` with all lower lines below upper ones."""
    for a in range(count):
        for b in range(count):
            falls = lower[b, 1] - upper[a, 1]
            if falls > 0.0:
                most = min(most, (upper[a, 0] - lower[b, 0]) / falls)
    return max(most, 0.0)
