"""A splat from before, brought up to date by live frames."""

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.carving import find_gone
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

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
    kept = base.select(~find_gone(base.p_GK, capture))
    added = seen.select(~find_covered(kept, seen))
    if not kept.is_surfel:
        added = with_thickness(added)
    return kept.joined_with(added)


def find_covered(base: GaussianSplat, seen: GaussianSplat) -> np.ndarray:
    """Discs at surfaces that the base has as well, (n,) bool."""
    covered = np.zeros(len(seen), bool)
    # Two standard deviations reach over the gaps between discs.
    field = SphereToEllipsoidField(base, n_sigma=2.0)
    near = field.clearances(Spheres.at(seen.p_GK.reshape(-1, 3)), _COVERED)
    covered[near.sphere] = True
    return covered
