"""Checks distance queries of spheres, and makes arrays of them for kernels."""

import math

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import Maps, clearance_rows
from remosplat_drake.signals.distance_field import Clearances

UNDEFINED = (
    "a sphere's centre is not finite, or its radius or ignore_below is NaN"
)
"""Error message for invalid spheres. Comparisons with NaN are false, so a
sphere with a NaN would count as free of collision."""


def query_maps(
    maps: Packed[Maps], spheres: Spheres, max_distance: float, revision: str
) -> Clearances:
    """Computes the clearances from several maps in one compiled call.

    Args:
        maps: The maps, in the form of `DistanceField.compiled_rows`.
        spheres: The n robot spheres, placed in W.
        max_distance: Rows at or beyond this distance are omitted [m].
        revision: Name of the maps' content, which the result contains.

    Raises:
        ValueError: A centre is not finite, or a radius or `ignore_below` is
            NaN.
    """
    sphere, distance, direction_W, p_WC, is_defined = clearance_rows(
        maps,
        # The arrays are copied, since kernels are compiled for writable arrays.
        np.array(spheres.p_WS, float),
        np.array(spheres.radius, float),
        np.array(spheres.ignore_below, float),
        np.array(spheres.index, np.int64),
        float(max_distance),
    )
    if not is_defined:
        raise ValueError(UNDEFINED)
    return Clearances(sphere, distance, direction_W, p_WC, revision)


def sphere_queries(spheres: Spheres, max_distance: float) -> np.ndarray:
    """Makes the array of queries for `compiled_map.query_map`.

    Args:
        spheres: The n robot spheres, placed in W.
        max_distance: Distance from a sphere's surface below which surfaces are
            searched [m].

    Returns:
        The queries, shape (n, 6). The columns are the centres, the distances
        from the centres below which surfaces are searched, the heights below
        which the scene is ignored [m], and the indices of the spheres.

    Raises:
        ValueError: A centre is not finite, or a radius or `ignore_below` is
            NaN.
    """
    asked = np.empty((len(spheres), 6))
    asked[:, :3] = spheres.p_WS
    asked[:, 3] = spheres.radius
    asked[:, 3] += max_distance
    asked[:, 4] = spheres.ignore_below
    asked[:, 5] = spheres.index
    # Sums and minima propagate NaN.
    is_finite = math.isfinite(asked[:, :3].sum())
    if not is_finite or math.isnan(asked[:, 3:5].min(initial=0.0)):
        raise ValueError(UNDEFINED)
    return asked
