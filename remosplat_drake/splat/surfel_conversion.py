"""Converts between 2DGS discs and 3DGS ellipsoids.

Most formats of splats support only ellipsoids. A disc is written as an
ellipsoid with the least thickness that all formats can represent, and is read
as a disc again.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.splat.gaussian_splat import GaussianSplat

THICKNESS = float(np.exp(-10.0))
"""Third scale of a disc in formats for ellipsoids, exp(-10) m = 45 um.

It is the least scale of SPZ.
"""

_FLAT = 1e-4
"""Ellipsoids count as discs if their third scales are at most this length [m].
Their third scales must be equal, too."""

_TO_THIRD = np.array([[0.5, 0.5, 0.5, 0.5], [0.5, -0.5, -0.5, -0.5]])
"""Quaternions wxyz of two rotations, which rotate z to axis 0 and to axis 1."""


def is_flat(splat: GaussianSplat) -> bool:
    """Returns whether all ellipsoids are discs to which a thickness was added.

    They are if their third scales are all equal, to float precision, and at
    most 0.1 mm. Training does not produce such ellipsoids.
    """
    if splat.is_surfel or not len(splat):
        return False
    third = splat.scales[:, 2]
    return bool(third.max() <= min(_FLAT, 1.001 * third.min()))


def without_thickness(splat: GaussianSplat) -> GaussianSplat:
    """Returns the discs spanned by the first two axes of each splat."""
    return dc.replace(splat, scales=splat.scales[:, :2])


def with_thickness(splat: GaussianSplat) -> GaussianSplat:
    """Converts discs to ellipsoids with the third scale `THICKNESS`.

    Ellipsoids are returned unchanged. If a scale of a disc is below
    `THICKNESS`, the disc's normal is not the shortest axis of the ellipsoid.
    """
    if not splat.is_surfel:
        return splat
    third = np.full((len(splat), 1), THICKNESS)
    return dc.replace(splat, scales=np.hstack([splat.scales, third]))


def flattened(splat: GaussianSplat) -> GaussianSplat:
    """Converts ellipsoids to discs, whose normals are the shortest axes.

    The axes of K are permuted cyclically, so that R_GK remains a rotation. They
    become y, z, x if the first axis is the shortest, and z, x, y if the second
    axis is the shortest. If scales are equal, the last axis is the normal.
    Discs are returned unchanged.
    """
    if splat.is_surfel:
        return splat
    shortest = 2 - splat.scales[:, ::-1].argmin(axis=1)
    quaternions = splat.quaternions.astype(np.float64)
    scales = splat.scales[:, :2].copy()
    for axis, turn in enumerate(_TO_THIRD):
        chosen = shortest == axis
        quaternions[chosen] = _times(quaternions[chosen], turn)
        kept = [(axis + 1) % 3, (axis + 2) % 3]
        scales[chosen] = splat.scales[np.ix_(chosen, kept)]
    return dc.replace(splat, quaternions=quaternions, scales=scales)


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the products of many quaternions a with one b, wxyz, (N, 4)."""
    w, x, y, z = b
    right = np.array(
        [[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]]
    )
    return a @ right
