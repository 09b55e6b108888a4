"""Searches paths by RRT-Connect (Kuffner and LaValle 2000).

The smaller of two trees takes a step towards a random configuration. The other
tree then grows towards the new node, as far as the motion is free. Since the
smaller tree takes the step, a tree that is confined, for example because the
hand is in a shelf, gets as many nodes as the other tree.

The caller draws the random configurations. So the kernel has no random state,
and equal calls return equal trees.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, several
from remosplat_drake.controller.planning.kernels.collision_checks import (
    is_free,
    is_free_between,
    moves_freely,
)
from remosplat_drake.controller.planning.kernels.trees import (
    GOAL,
    START,
    add_node,
    nearest,
)
from remosplat_drake.controller.planning.steering import wrapped

_STEP = 2.0
"""Longest step of a tree in q. A radian counts like a metre."""

_THERE = 1e-9
"""Distance within which a tree has reached a configuration."""

NOT_MET = -1
"""Value that replaces a node if the trees do not meet."""


@kernel(returns=several(WHOLE, WHOLE, WHOLE))
def grow(space, line, trees, draws, most):
    """Grows two trees until they meet, or until all draws or checks are used.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        trees: The `Trees`, to which nodes are added. Each tree must have memory
            for `most` more nodes.
        draws: Random configurations, shape (k, n_q) [rad, m], which are
            overwritten.
        most: Largest number of motions to check.

    Returns:
        The number of checked motions, and the nodes at which the start's tree
        and the goals' tree meet, or `NOT_MET`.
    """
    checks = 0
    q, other_q = np.empty(draws.shape[1]), np.empty(draws.shape[1])
    for k in range(len(draws)):
        if checks == most:
            break
        tree = START if trees.count[START] <= trees.count[GOAL] else GOAL
        other = 1 - tree
        checks += 1
        node, _ = _step(space, line, trees, tree, draws[k], q)
        if node == NOT_MET:
            continue
        for j in range(len(q)):
            draws[k, j] = q[j]
        is_there = False
        while checks < most and not is_there:
            checks += 1
            end, is_there = _step(space, line, trees, other, draws[k], other_q)
            if end == NOT_MET:
                break
            if is_there:
                met = (node, end) if tree == START else (end, node)
                return checks, met[0], met[1]
    return checks, NOT_MET, NOT_MET


@helper
def _step(space, line, trees, tree, towards, q):
    """Grows a tree by one step, and writes the configuration that it reaches.

    Returns:
        The new node, or `NOT_MET` if the step is not free; and whether the tree
        has reached the given configuration.
    """
    n_base = space.robot.n_base
    near = nearest(trees, tree, towards, n_base)
    square = 0.0
    for j in range(len(q)):
        q[j] = towards[j] - trees.q[tree, j, near]
        if n_base > 0 and j == 2:
            q[j] = wrapped(q[j])
        square += q[j] * q[j]
    length = math.sqrt(square)
    share = min(_STEP / length, 1.0) if length > _THERE else 1.0
    near_q = np.empty(len(q))
    for j in range(len(q)):
        near_q[j] = trees.q[tree, j, near]
        q[j] = near_q[j] + share * q[j] if share < 1.0 else towards[j]
    # The motion is checked in the direction of travel, since a base moves
    # differently in the reverse direction.
    if tree == START:
        is_open = is_free_between(space, line, near_q, q)
    else:
        is_open = is_free(space, line, q) and moves_freely(
            space, line, q, near_q
        )
    if not is_open:
        return NOT_MET, False
    return add_node(trees, tree, q, near), share == 1.0
