"""Splats in clusters of 32 neighbours, for search on a GPU.

A warp of 32 threads tests the 32 boxes or splats of one node at a time, so each
node of the hierarchy has 32 children, and needs no links to them. Splats are
sorted along a space-filling curve, with large splats apart from small ones.
Clusters are consecutive runs of this order: sorting is the whole construction.
"""

import ctypes
import dataclasses as dc
from collections.abc import Callable

import numpy as np

CLUSTER = 32
"""Number of splats of a cluster, and of clusters of a group."""

_BITS = 20
"""Bits of each coordinate along the curve: three coordinates fill 60."""

_SPREAD = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
"""Shifts and masks that put two empty bits between all bits of a number."""


@dc.dataclass(frozen=True, eq=False)
class Clusters:
    """Splats in the order of a curve, and the boxes around them.

    Attributes:
        records: Data of each splat for kernels, shape (N, 16), float32.
        clusters: Boxes of 32 splats each, shape (K, 8), float32: lower corner,
            height of the highest centre inside, upper corner, zero [m].
        groups: Boxes of 32 clusters each, of the same shape (M, 8).
        order: The splats' indices in the order of the records, shape (N,),
            int32.
    """

    records: np.ndarray
    clusters: np.ndarray
    groups: np.ndarray
    order: np.ndarray


class ClustersArgument(ctypes.Structure):
    """`Clusters` as an argument of kernels: addresses and counts."""

    _fields_ = (
        ("records", ctypes.c_void_p),
        ("clusters", ctypes.c_void_p),
        ("groups", ctypes.c_void_p),
        ("n_splats", ctypes.c_int),
        ("n_clusters", ctypes.c_int),
        ("n_groups", ctypes.c_int),
    )

    @staticmethod
    def of(arrays, address: Callable) -> "ClustersArgument":
        """Makes the argument from arrays or tensors like those of `Clusters`.

        Args:
            arrays: An object with the attributes of `Clusters`.
            address: Function that returns an array's address.
        """
        return ClustersArgument(
            address(arrays.records),
            address(arrays.clusters),
            address(arrays.groups),
            len(arrays.records),
            len(arrays.clusters),
            len(arrays.groups),
        )


def make_clusters(
    records: np.ndarray, half: np.ndarray, index: np.ndarray
) -> Clusters:
    """Sorts splats into clusters.

    Args:
        records: Data of each splat for kernels, shape (N, 16); the first three
            columns are its centre [m].
        half: Half edges of the boxes around the splats, shape (N, 3) [m].
        index: The splats' indices, shape (N,).
    """
    center = records[:, :3]
    order = curve_order(center, half.max(axis=1, initial=0.0))
    records, center, half = records[order], center[order], half[order]
    clusters = np.empty((-(-len(records) // CLUSTER), 8))
    if len(records):
        clusters[:, :3] = _reduced(np.minimum, center - half)
        clusters[:, 3] = _reduced(np.maximum, center[:, 2])
        clusters[:, 4:7] = _reduced(np.maximum, center + half)
    clusters[:, 7] = 0.0
    groups = np.empty((-(-len(clusters) // CLUSTER), 8))
    if len(clusters):
        groups[:, :3] = _reduced(np.minimum, clusters[:, :3])
        groups[:, 3:] = _reduced(np.maximum, clusters[:, 3:])
    return Clusters(
        records.astype(np.float32),
        _outwards(clusters),
        _outwards(groups),
        index[order].astype(np.int32),
    )


def curve_order(center: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Sorts splats along a Morton curve, those of similar size together.

    A splat much larger than its neighbours would enlarge the box of its whole
    cluster.

    Args:
        center: Centres, shape (N, 3) [m].
        size: Sizes, shape (N,) [m].

    Returns:
        The splats' indices in that order, shape (N,).
    """
    if len(center) == 0:
        return np.zeros(0, np.int64)
    lower = center.min(axis=0)
    extent = np.maximum(np.ptp(center, axis=0).max(), 1e-30)
    cells = ((2**_BITS - 1) * ((center - lower) / extent)).astype(np.uint64)
    key = np.zeros(len(center), np.uint64)
    for axis in range(3):
        column = cells[:, axis]
        for shift, mask in _SPREAD:
            column = (column | column << np.uint64(shift)) & np.uint64(mask)
        key |= column << np.uint64(axis)
    middle = max(float(np.median(size)), 1e-30)
    kind = np.log2(np.maximum(size / middle, 1.0)) / 2
    key |= np.minimum(kind, 15).astype(np.uint64) << np.uint64(3 * _BITS)
    return np.argsort(key, kind="stable")


def _reduced(function: np.ufunc, values: np.ndarray) -> np.ndarray:
    starts = np.arange(0, len(values), CLUSTER)
    return function.reduceat(values, starts, axis=0)


def _outwards(boxes: np.ndarray) -> np.ndarray:
    """Rounds boxes outwards to single precision."""
    rounded = boxes.astype(np.float32)
    rounded[:, :3] = np.nextafter(rounded[:, :3], np.float32(-np.inf))
    rounded[:, 3:7] = np.nextafter(rounded[:, 3:7], np.float32(np.inf))
    return rounded


def split_positions(p_WS: np.ndarray) -> np.ndarray:
    """Splits positions into sums of two triples of floats.

    The difference from a nearby point then keeps single precision.

    Args:
        p_WS: Positions, shape (..., 3) [m].

    Returns:
        The rounded positions and the remainders, shape (..., 6), float32.
    """
    rounded = p_WS.astype(np.float32)
    rest = (p_WS - rounded).astype(np.float32)
    return np.concatenate([rounded, rest], axis=-1)
