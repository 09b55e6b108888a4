"""Free space that views have looked through, and surfaces in it."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_HOLE = 1.6
"""Distance in standard deviations of a former disc within which another centre
must be; otherwise there is a hole."""

_ENOUGH_VIEWS = 2
"""Number of views that must look through a disc to remove it."""

_FREE = 0.03
"""A disc that views looked through is a floater where no other disc is nearer
than this; else views only disagree by a little about one surface [m]."""


def drop_floaters(capture: Capture, splat: GaussianSplat) -> GaussianSplat:
    """Removes discs in space that views have looked through.

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
    """Puts back discs where an optimisation lost a surface.

    Surfaces seen only at a grazing angle, or at different positions by views
    with wrong poses, may fade or be merged. A hole hides an obstacle, so such
    discs are put back as they were, unless views looked through them.

    Args:
        capture: Posed RGB-D images.
        splat: The splat that an optimisation has made of `before`; in W.
        before: The splat at which it started; in W.

    Returns:
        The splat with the discs that were put back.
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
