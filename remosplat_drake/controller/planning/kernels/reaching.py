"""Searches free configurations that reach targets, from random draws.

Fast checks come first. The parts that the arms do not move are checked before
inverse kinematics. The whole robot is checked only if the targets are reached.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, reals, several, truths
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.base_spheres import (
    base_spheres,
    may_stand,
)
from remosplat_drake.controller.planning.kernels.collision_checks import is_free
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    reach_from,
)

TOLERANCE = 2e-3
"""Largest pose error of a goal configuration, with angles times 0.3 m [m]. If
no joint limit is active, the error is below a hundredth of this value."""

_STEPS = 15
"""Largest number of steps of inverse kinematics from a seed."""


@kernel(returns=several(reals(2), truths(1), WHOLE))
def reaching(space, line, arms, draws, most):
    """Searches configurations that reach targets, until enough are free.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        arms: The `Arms`.
        draws: Groups of random configurations, shape (k, g, n_q) [rad, m]. The
            base pose of a group is that of its first configuration. The
            configuration of a group that is nearest to the targets is the seed.
        most: Number of free configurations at which the search ends.

    Returns:
        The m configurations that reach the targets, shape (m, n_q) [rad, m];
        whether each of them is free, shape (m,); and the number of seeds. A
        group whose base pose is not free has no seed.
    """
    base, count, free, seeds = base_spheres(space), 0, 0, 0
    found = np.empty((len(draws), draws.shape[2]))
    is_open = np.empty(len(draws), np.bool_)
    q, error = np.empty((draws.shape[2], WIDTH)), np.empty(WIDTH)
    group, k = np.empty(WIDTH, np.int64), 0
    while k < len(draws) and free < most:
        lanes = 0
        while k < len(draws) and lanes < WIDTH:
            if may_stand(space, line, base, draws[k, 0]):
                group[lanes], lanes = k, lanes + 1
            k += 1
        if lanes == 0:
            break
        group[lanes:] = group[0]
        _write_seeds(arms, draws, group, q)
        reach_from(arms, q, _STEPS, 0.01 * TOLERANCE, error)
        for lane in range(lanes):
            if free >= most:
                break
            seeds += 1
            if error[lane] < TOLERANCE:
                found[count] = q[:, lane]
                is_open[count] = is_free(space, line, found[count])
                free += is_open[count]
                count += 1
    return found[:count].copy(), is_open[:count].copy(), seeds


@helper
def _write_seeds(arms, draws, group, q):
    """Writes the draw of each of eight groups that is nearest to the aim."""
    trial, error = np.empty(q.shape), np.empty(WIDTH)
    nearest = np.full(WIDTH, np.inf)
    for draw in range(draws.shape[1]):
        for lane in range(WIDTH):
            for j in range(len(q)):
                from_base = draw if j >= arms.first else 0
                trial[j, lane] = draws[group[lane], from_base, j]
        if draws.shape[1] > 1:
            reach_from(arms, trial, 0, TOLERANCE, error)
        else:
            error[:] = 0.0
        for lane in range(WIDTH):
            if error[lane] < nearest[lane]:
                nearest[lane] = error[lane]
                q[:, lane] = trial[:, lane]
