"""Computes clearances from the nearest pixels of depth views."""

import numpy as np

from remosplat_drake.oracle.depth_sensor import R_DV, DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances


def nearest_rows(
    spheres: Spheres,
    sensor: DepthSensor,
    reach: np.ndarray,
    pixel: np.ndarray,
    revision: str,
) -> Clearances:
    """Returns a row of clearances for each view that contains a surface.

    Args:
        spheres: The n robot spheres, each with a depth sensor at its centre.
        sensor: Settings of the six views.
        reach: Range of each view's nearest pixel along its ray, shape (n, 6)
            [m]; inf if there is none.
        pixel: Row-major index of this nearest pixel, shape (n, 6).
        revision: Revision of the field.

    Returns:
        The rows, sorted by sphere and then by view.
    """
    sphere, view = np.nonzero(np.isfinite(reach))
    reach, pixel = reach[sphere, view], pixel[sphere, view]
    row, column = np.divmod(pixel, sensor.resolution)
    axis = sensor.pixel_centers()
    ray_V = np.stack([axis[column], axis[row], np.ones(len(row))], axis=1)
    ray_V /= np.linalg.norm(ray_V, axis=1, keepdims=True)
    R_WD = sensor.R_WD(spheres.R_WL)[sphere]
    direction_W = np.einsum("nij,njk,nk->ni", R_WD, R_DV[view], ray_V)
    return Clearances(
        sphere,
        reach - spheres.radius[sphere],
        direction_W,
        spheres.p_WS[sphere] + reach[:, None] * direction_W,
        revision,
    )
