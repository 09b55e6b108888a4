"""Sorts splats into clusters of 32 neighbours, for search on a GPU.

A warp of 32 GPU threads tests the 32 boxes or splats of one node in parallel.
So each node of the hierarchy has 32 children, and no links to them are stored.
Splats are sorted along a space-filling curve, and large splats separately from
small ones. A cluster consists of 32 consecutive splats in this order, so the
sort is the whole construction.
"""

import ctypes
import dataclasses as dc
from collections.abc import Callable

import numpy as np

CLUSTER = 32
"""Number of splats in a cluster, and of clusters in a group."""

_BITS = 20
"""Number of bits of each coordinate on the curve. Three coordinates take 60
bits."""

_SPREAD = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
"""Shifts and masks that insert two zero bits between adjacent bits of a
number."""


@dc.dataclass(frozen=True, eq=False)
class Clusters:
    """Splats sorted along a space-filling curve, and boxes around clusters.

    Attributes:
        records: Data of each splat for kernels, shape (N, 16), float32.
        clusters: Bounding boxes of 32 splats each, shape (K, 8), float32. The
            columns are the lower corner, the height of the highest splat centre
            in the box, the upper corner, and zero [m].
        groups: Bounding boxes of 32 clusters each, shape (M, 8), with the same
            columns.
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
        """Makes the argument from the arrays of `Clusters`, or from tensors.

        Args:
            arrays: An object with the attributes of `Clusters`, as arrays or
                tensors.
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
        half: Half edges of each splat's bounding box, shape (N, 3) [m].
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
    """Sorts splats by size class, and then along a Morton curve.

    The sizes are separated, since a splat that is much larger than its
    neighbours would enlarge the box of its whole cluster.

    Args:
        center: Centres, shape (N, 3) [m].
        size: Sizes of the splats, shape (N,) [m].

    Returns:
        The splats' indices in the sorted order, shape (N,).
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
    """Rounds the corners of boxes outwards to single precision."""
    rounded = boxes.astype(np.float32)
    rounded[:, :3] = np.nextafter(rounded[:, :3], np.float32(-np.inf))
    rounded[:, 3:7] = np.nextafter(rounded[:, 3:7], np.float32(np.inf))
    return rounded


def split_positions(p_WS: np.ndarray) -> np.ndarray:
    """Splits positions into sums of two vectors in single precision.

    So the difference between a position and a nearby point can be computed to
    the precision of a float.

    Args:
        p_WS: Positions, shape (..., 3) [m].

    Returns:
        The rounded positions and the remainders, shape (..., 6), float32.
    """
    rounded = p_WS.astype(np.float32)
    rest = (p_WS - rounded).astype(np.float32)
    return np.concatenate([rounded, rest], axis=-1)
