"""Updates a splat from before the run with frames of the run."""

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import sample_points, to_world
from remosplat_drake.mapping.carving import find_gone
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

_COVERED = 0.01
"""A point's surface is not new if a disc of the earlier splat is within this
distance of the point [m].
"""

_SAMPLES = 400
"""This many points of a frame are compared with the earlier splat."""


def updated(
    base: GaussianSplat, seen: GaussianSplat, capture: Capture
) -> GaussianSplat:
    """Removes vanished objects from a splat, and adds new ones.

    Args:
        base: The splat from before the run, in W.
        seen: Discs on the surfaces that the live frames show, in W.
        capture: The live frames, without their outdated parts.

    Returns:
        The updated splat, in W.
    """
    kept = base.select(~find_gone(base.p_GK, capture))
    added = seen.select(~find_covered(kept, seen.p_GK))
    if not kept.is_surfel:
        added = with_thickness(added)
    if kept.uncertainty is None and added.uncertainty is not None:
        # The stopping distance covers the error of the earlier splat
        # (`scene.map_error`), so no uncertainty is subtracted.
        kept = kept.with_uncertainty(0.0)
    return kept.joined_with(added)


def find_covered(base: GaussianSplat, p_WQ: np.ndarray) -> np.ndarray:
    """Finds the points whose surfaces an earlier splat already contains.

    Args:
        base: The splat from before the run, in W.
        p_WQ: Points on surfaces in live frames, shape (n, 3) [m].

    Returns:
        A mask of the points, shape (n,).
    """
    covered = np.zeros(len(p_WQ), bool)
    # Discs of two standard deviations leave no gaps between each other.
    surfaces = base.with_uncertainty(None)
    field = SphereToEllipsoidField(surfaces, n_sigma=2.0)
    near = field.clearances(Spheres.at(p_WQ.reshape(-1, 3)), _COVERED)
    covered[near.sphere] = True
    return covered


def shares_of(base: GaussianSplat, capture: Capture) -> np.ndarray:
    """Computes the fraction of each frame's surfaces that a splat contains.

    Args:
        base: The splat from before the run, in W.
        capture: The n live frames.

    Returns:
        Fractions of the frames' surfaces, shape (n,); 0 for a frame without
        depth.
    """
    p_C = sample_points(capture, _SAMPLES, np.random.default_rng(0))
    shares = np.zeros(len(capture))
    for view, points in enumerate(p_C):
        if not np.isnan(points).any():
            p_WQ = to_world(capture, points, view)
            shares[view] = find_covered(base, p_WQ).mean()
    return shares
