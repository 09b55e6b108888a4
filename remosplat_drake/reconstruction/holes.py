"""Holes that an optimisation leaves, and how they are filled."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_HOLE = 1.6
"""Where a disc was, and none has its centre within so many of its standard
deviations, there is a hole."""

_ENOUGH_VIEWS = 2
"""So many views must have looked through a disc for it to be gone."""


def fill_holes(
    capture: Capture, splat: GaussianSplat, before: GaussianSplat
) -> GaussianSplat:
    """The splat, and discs from before where it lost a surface.

    What only one slanted view has seen, or what views with wrong poses see in
    different places, may fade or be merged away. A hole hides an obstacle, so
    such discs are put back as they were, unless views looked through them.

    Args:
        capture: Posed RGB-D images.
        splat: What an optimisation has made of `before`; in W.
        before: Where it started; in W.
    """
    apart, _ = KDTree(splat.p_GK).query(before.p_GK)
    lost = np.flatnonzero(apart > _HOLE * before.scales.max(axis=1))
    looked_through = times_looked_through(capture, before.p_GK[lost])
    return splat.joined_with(
        before.select(lost[looked_through < _ENOUGH_VIEWS])
    )
