"""Splats prepared for ray tests, in a complete binary tree of boxes."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.splat.gaussian_splat import GaussianSplat

LEAF_SIZE = 8


class Footprints(NamedTuple):
    """m splats that can be seen at all, ordered along a Morton curve.

    Attributes:
        center: Centres in W, shape (m, 3) [m].
        whiten: Rows map W to the splat's axes in standard deviations, shape
            (m, 3, 3). A disc's third row is its unit normal.
        opacity: Shape (m,).
        weight_cut: Largest squared Mahalanobis distance that is seen, (m,).
        radius: Of the ball around everything that is seen, shape (m,) [m].
    """

    center: np.ndarray
    whiten: np.ndarray
    opacity: np.ndarray
    weight_cut: np.ndarray
    radius: np.ndarray


class BoxTree(NamedTuple):
    """Boxes around runs of footprints; node i has children 2i+1 and 2i+2.

    Attributes:
        middle: Centres of the boxes, shape (2 L - 1, 3) [m].
        half: Their half-extents, shape (2 L - 1, 3) [m].
        top: Height of the highest splat centre below each node [m].
        start: Leaf j of the L leaves holds footprints start[j]:start[j + 1].
    """

    middle: np.ndarray
    half: np.ndarray
    top: np.ndarray
    start: np.ndarray


def prepare(
    splat: GaussianSplat, sensor: DepthSensor
) -> tuple[Footprints, BoxTree] | None:
    """What a sensor can see of a splat in W; None where that is nothing."""
    opacity = splat.opacities.astype(float)
    with np.errstate(divide="ignore"):
        # alpha >= min_alpha is weight <= 2 ln(opacity / min_alpha).
        weight_cut = np.minimum(
            sensor.n_sigma**2, 2 * np.log(opacity / sensor.min_alpha)
        )
    seen = np.flatnonzero(weight_cut >= 0)
    if len(seen) == 0:
        return None
    seen = seen[np.argsort(_morton_codes(splat.p_GK[seen]), kind="stable")]
    center, weight_cut = splat.p_GK[seen].astype(float), weight_cut[seen]
    scales = splat.scales[seen].astype(float)
    axes = splat.R_GK[seen]
    k = scales.shape[1]
    whiten = np.ascontiguousarray(np.swapaxes(axes, 1, 2))
    whiten[:, :k] /= scales[:, :, None]
    reach = np.sqrt(weight_cut)
    extent = np.linalg.norm(axes[:, :, :k] * scales[:, None], axis=2)
    return (
        Footprints(
            center,
            whiten,
            opacity[seen],
            weight_cut,
            reach * scales.max(axis=1),
        ),
        _box_tree(center, reach[:, None] * extent),
    )


def _box_tree(center: np.ndarray, extent: np.ndarray) -> BoxTree:
    """The tree over boxes center +- extent, both (m, 3), in their order."""
    m = len(center)
    leaves = 1 << max(0, int(np.ceil(np.log2(m / LEAF_SIZE))))
    start = np.arange(leaves + 1) * m // leaves
    lower = np.minimum.reduceat(center - extent, start[:-1])
    upper = np.maximum.reduceat(center + extent, start[:-1])
    top = np.maximum.reduceat(center[:, 2], start[:-1])
    levels = [(lower, upper, top)]
    while len(top) > 1:
        lower = np.minimum(lower[::2], lower[1::2])
        upper = np.maximum(upper[::2], upper[1::2])
        top = np.maximum(top[::2], top[1::2])
        levels.insert(0, (lower, upper, top))
    lower, upper, top = (
        np.concatenate(parts) for parts in zip(*levels, strict=True)
    )
    return BoxTree((lower + upper) / 2, (upper - lower) / 2, top, start)


def _morton_codes(points: np.ndarray) -> np.ndarray:
    """Positions along a Z-order curve: 21 bits an axis, interleaved."""
    if len(points) == 0:
        return np.zeros(0, np.uint64)
    lower = points.min(axis=0)
    size = max(float((points - lower).max()), 1e-9)
    cells = ((points - lower) / size * (2**21 - 1)).astype(np.uint64)
    masks = (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    )
    for shift, mask in masks:
        cells = (cells | (cells << np.uint64(shift))) & np.uint64(mask)
    return (
        cells[:, 0] | cells[:, 1] << np.uint64(1) | cells[:, 2] << np.uint64(2)
    )
