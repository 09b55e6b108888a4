"""Adds floaters: faint splats in free space, as in poor reconstructions."""

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

FAINTEST = 1 / 255
"""Smallest opacity of floaters. It is the renderer's threshold, since training
lowers the opacity of floaters down to it."""

SCALE_MEDIAN, SCALE_SPREAD = 0.075, 0.45
"""Sizes of floaters are log-normal: their median [m], and the standard
deviation of their logarithm."""

FADED = 0.9
"""Fraction of the floaters that training has faded to `FAINTEST`."""

LOG_OPACITY_MEAN = 1.5
"""Mean of ln(opacity / FAINTEST) of floaters that have not faded to `FAINTEST`;
this value is exponentially distributed."""

MIN_DISTANCE = 0.02
"""The centre of a floater is at least this far from the true surfaces [m]."""


def with_floaters(
    splat_W: GaussianSplat,
    truth: DistanceField,
    count: int,
    seed: int = 0,
) -> GaussianSplat:
    """Returns a splat with random discs added in the free part of its box.

    The box contains the splat's centres above the floor. The paper's experiment
    3 adds random points in such a box before training. Sizes and opacities of
    the added floaters follow distributions that were fitted to 1,000 such
    points after 1,000 steps of training on a table: nine in ten faded to 1/255,
    and one in a hundred kept an opacity above 0.1. Floaters are large: their
    median standard deviation is 75 mm, while discs on surfaces have about 10
    mm.

    Args:
        splat_W: Splat of surfels, expressed in W.
        truth: Distances to the true scene; no floater is in its solids or at
            its surfaces.
        count: Number of floaters to add.
        seed: Seed of the random numbers.
    """
    rng = np.random.default_rng(seed)
    faded = rng.uniform(size=count) < FADED
    log_opacity = rng.exponential(LOG_OPACITY_MEAN, count)
    opacity = FAINTEST * np.exp(np.where(faded, 0.0, log_opacity))
    scales = SCALE_MEDIAN * np.exp(rng.normal(0, SCALE_SPREAD, (count, 2)))
    floaters = GaussianSplat(
        p_GK=_free_points(splat_W, truth, count, rng),
        quaternions=rng.normal(size=(count, 4)),
        scales=scales,
        opacities=np.minimum(opacity, 0.97),
        colors=rng.uniform(size=(count, 3)),
        sh_rest=np.zeros((count, *splat_W.sh_rest.shape[1:])),
    )
    return splat_W.joined_with(floaters)


def _free_points(
    splat_W: GaussianSplat,
    truth: DistanceField,
    count: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Draws points (count, 3) in the box that are in no solid, in W [m]."""
    p_WK = splat_W.p_GK[splat_W.p_GK[:, 2] > MIN_DISTANCE]
    lower, upper = np.quantile(p_WK, [0.001, 0.999], axis=0)
    points = np.zeros((0, 3))
    while len(points) < count:
        p_WP = rng.uniform(lower, upper, (count, 3))
        distance = truth.clearances(Spheres.at(p_WP)).per_sphere(count)
        points = np.concatenate([points, p_WP[distance > MIN_DISTANCE]])
    return points[:count]
