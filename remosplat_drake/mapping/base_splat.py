"""A splat from an earlier day, brought up to date by live frames."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.measured_space import times_looked_through
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

_APART = 0.03
"""Of a thing that has gone, some part is farther than this from all that is
still there; edges that views disagree about a little are not [m]."""

_FOOT = 0.01
"""Near such a part, views need to see only as far as this past a disc [m]."""

_COVERED = 0.01
"""A new disc that is nearer than this to an old one shows nothing new [m]."""


def updated(
    base: GaussianSplat, seen: GaussianSplat, capture: Capture
) -> GaussianSplat:
    """The base without what has gone, and with what has come.

    Args:
        base: The splat from before, in W.
        seen: Discs of what live frames show, in W.
        capture: The live frames, without what is out of date in them.
    """
    kept = base.select(~find_gone(base, capture))
    added = seen.select(~find_covered(kept, seen))
    if not kept.is_surfel:
        added = with_thickness(added)
    return kept.joined_with(added)


def find_gone(base: GaussianSplat, capture: Capture) -> np.ndarray:
    """Discs of things that views have looked through, (n,) bool.

    The foot of a thing goes with it: it is near to what it stood on, so that
    views look past it by little.
    """
    through = times_looked_through(capture, base.p_GK) > 0
    if through.all() or not through.any():
        return through
    apart, _ = KDTree(base.p_GK[~through]).query(base.p_GK)
    core = through & (apart > _APART)
    if not core.any():
        return core
    apart, _ = KDTree(base.p_GK[core]).query(base.p_GK)
    foot = np.flatnonzero(~core & (apart < 2 * _APART))
    past = times_looked_through(capture, base.p_GK[foot], _FOOT) > 0
    core[foot[past]] = True
    return core


def find_covered(base: GaussianSplat, seen: GaussianSplat) -> np.ndarray:
    """Discs at surfaces that the base has as well, (n,) bool."""
    covered = np.zeros(len(seen), bool)
    # Two standard deviations reach over the gaps between discs.
    field = SphereToEllipsoidField(base, n_sigma=2.0)
    near = field.clearances(Spheres.at(seen.p_GK.reshape(-1, 3)), _COVERED)
    covered[near.sphere] = True
    return covered
