"""Removes discs in free space, and restores discs of lost surfaces."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_HOLE = 1.6
"""A former disc leaves a hole if no centre of another disc is within this
multiple of the former disc's standard deviations.
"""

_ENOUGH_VIEWS = 2
"""A disc is removed if at least this many views measure a surface behind it."""

_FREE = 0.03
"""A disc in free space is not removed if a disc that is not in free space is
nearer to it than this [m]. In this case, the views only disagree slightly about
the position of a surface.
"""


def drop_floaters(capture: Capture, splat: GaussianSplat) -> GaussianSplat:
    """Removes discs in space that views have seen as free.

    Args:
        capture: Posed RGB-D images.
        splat: A splat of discs in W.
    """
    normal_W = splat.R_GK[:, :, 2]
    through = times_looked_through(capture, splat.p_GK, normal_W=normal_W)
    through = through >= _ENOUGH_VIEWS
    if through.all():
        return splat
    apart, _ = KDTree(splat.p_GK[~through]).query(splat.p_GK)
    return splat.select(~through | (apart < _FREE))


def fill_holes(
    capture: Capture, splat: GaussianSplat, before: GaussianSplat
) -> GaussianSplat:
    """Restores discs on surfaces that an optimisation has lost.

    The discs of a surface may fade or be merged if it was seen only at a
    grazing angle, or at different positions by views with wrong poses. The hole
    would hide an obstacle, so the former discs are restored, unless views have
    measured surfaces behind them.

    Args:
        capture: Posed RGB-D images.
        splat: The optimised splat, in W.
        before: The splat before the optimisation, in W.

    Returns:
        The optimised splat with the restored discs.
    """
    apart, _ = KDTree(splat.p_GK).query(before.p_GK)
    lost = np.flatnonzero(apart > _HOLE * before.scales.max(axis=1))
    normal_W = before.R_GK[lost, :, 2]
    looked_through = times_looked_through(
        capture, before.p_GK[lost], normal_W=normal_W
    )
    return splat.joined_with(
        before.select(lost[looked_through < _ENOUGH_VIEWS])
    )
