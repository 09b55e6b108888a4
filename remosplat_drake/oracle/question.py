"""What kernels are asked of spheres, checked."""

import math

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres


def question(spheres: Spheres, max_distance: float) -> np.ndarray:
    """Makes the question that kernels of `compiled_map.ask` take.

    Args:
        spheres: The n robot spheres, placed in W.
        max_distance: Distance that an answer must undercut [m].

    Returns:
        Centres, distances from these that an answer must undercut, and heights
        below which nothing is seen, shape (n, 5) [m].

    Raises:
        ValueError: A centre is not finite, or a radius or floor is NaN.
    """
    asked = np.empty((len(spheres), 5))
    asked[:, :3] = spheres.p_WS
    asked[:, 3] = spheres.radius
    asked[:, 3] += max_distance
    asked[:, 4] = spheres.ignore_below
    # NaN compares as false everywhere: it would look like a free path. Sums
    # and minima pass it on.
    is_finite = math.isfinite(asked[:, :3].sum())
    if not is_finite or math.isnan(asked[:, 3:].min(initial=0.0)):
        raise ValueError("a sphere's centre, radius or floor is undefined")
    return asked
