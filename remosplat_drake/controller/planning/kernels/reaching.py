"""Searches random draws for free configurations that reach an aim.

Cheap checks come first: the parts that the arms do not move are checked before
inverse kinematics, the whole robot only if the aim is reached.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, reals, several, truths
from remosplat_drake.controller.planning.kernels.base_spheres import (
    base_spheres,
    may_stand,
)
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    reach_from,
)
from remosplat_drake.controller.planning.kernels.looks import is_free

TOLERANCE = 2e-3
"""Largest pose error of a goal configuration, with angles times 0.3 m [m]. If
no joint limit is active, the error is below a hundredth of this value."""

_STEPS = 15
"""Largest number of steps of inverse kinematics from a seed."""


@kernel(returns=several(reals(2), truths(1), WHOLE))
def reaching(space, line, arms, draws, most):
    """Solves for configurations that reach an aim, until enough are free.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        arms: The `Arms`.
        draws: Groups of configurations, all with the base pose of the group's
            first one, shape (k, g, n_q) [rad, m]. The configuration of a group
            nearest to the aim is the seed.
        most: Number of free configurations at which the search ends.

    Returns:
        Configurations that reach the aim, shape (m, n_q) [rad, m], which of
        them are free, shape (m,), and the number of seeds. A group whose base
        pose is not free has no seed.
    """
    base, count, free, seeds = base_spheres(space), 0, 0, 0
    found = np.empty((len(draws), draws.shape[2]))
    is_open = np.empty(len(draws), np.bool_)
    for k in range(len(draws)):
        if free >= most:
            break
        if not may_stand(space, line, base, draws[k, 0]):
            continue
        seeds += 1
        q = _nearest_draw(arms, draws[k])
        error = reach_from(arms, q, _STEPS, 0.01 * TOLERANCE)
        if error < TOLERANCE:
            found[count] = q
            is_open[count] = is_free(space, line, q)
            free += is_open[count]
            count += 1
    return found[:count].copy(), is_open[:count].copy(), seeds


@helper
def _nearest_draw(arms, draws):
    """Returns the draw nearest to the aim, with the first one's base pose."""
    best, least = 0, np.inf
    for k in range(len(draws)):
        for j in range(arms.first):
            draws[k, j] = draws[0, j]
        error = least
        if len(draws) > 1:
            error = reach_from(arms, draws[k], 0, TOLERANCE)
        if error < least:
            best, least = k, error
    return draws[best].copy()
