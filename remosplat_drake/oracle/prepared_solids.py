"""Builds the hierarchy of splats as solids for `SphereToEllipsoidField`."""

import hashlib
import zlib
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.threads import blocks, in_parallel
from remosplat_drake.oracle.kernels.solid_records import (
    are_enclosed,
    fill_boxes,
    open_solids,
    pack_solids,
)
from remosplat_drake.oracle.kernels.wide_tree import widen
from remosplat_drake.splat.bvh import (
    LEAF_SIZE,
    BoundingVolumeHierarchy,
    hierarchy_of,
    round_outwards,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.hierarchy_cache import (
    is_kept,
    keep_hierarchy,
    kept_hierarchy,
)

_NONE = np.zeros(0, np.float32)
_NONE.flags.writeable = False  # As a splat's arrays: one kernel.

PACKED = 12
"""Number of values of a splat that `pack_solids` has packed."""

_BLOCK = 1 << 12
"""Number of splats whose records fit into the cache of a processor core."""

_SHARE = 1 << 16
"""Number of consecutive splats or nodes that a thread processes."""


def prepare_solids(
    splat_W: GaussianSplat, n_sigma: float, min_opacity: float, solved: bool
) -> dict[str, np.ndarray]:
    """Builds a hierarchy of splats, or reads it from the user's cache.

    Args:
        splat_W: The Gaussian splat.
        n_sigma: Length of a splat's semi-axes in standard deviations.
        min_opacity: Splats below this opacity are omitted.
        solved: Whether closest points are computed to double precision.

    Returns:
        Four arrays, keyed by name. `wide` and `children` are the hierarchy,
        which `widen` makes. `records` are the splats in leaf order, packed by
        `pack_solids`, and `order` their indices in the splat.
    """
    index = _opaque(splat_W, min_opacity)
    if not is_kept(len(index)):
        hierarchy = hierarchy_of(_boxes(splat_W, index, n_sigma, solved))
        return _searched(splat_W, index, hierarchy)
    key = _key(splat_W, n_sigma, min_opacity, solved)
    hierarchy = kept_hierarchy(key, len(index))
    if hierarchy is not None:
        prepared = _searched(splat_W, index, hierarchy)
        if _holds(hierarchy, prepared["records"], n_sigma, solved):
            return prepared
        del prepared
    hierarchy = hierarchy_of(_boxes(splat_W, index, n_sigma, solved))
    keep_hierarchy(key, hierarchy)
    return _searched(splat_W, index, hierarchy)


def _key(
    splat_W: GaussianSplat, n_sigma: float, min_opacity: float, solved: bool
) -> str:
    """Returns the cache key of a hierarchy: a checksum of its inputs.

    The inputs are the shapes of the splats, but not their colours. Checksums
    are sufficient, and are faster than digests: if a hierarchy was made from
    other splats, or by a version that computes other boxes, a check of the
    boxes detects it.
    """
    arrays = [splat_W.p_GK, splat_W.quaternions, splat_W.scales]
    arrays.append(splat_W.opacities)
    if splat_W.uncertainty is not None:
        arrays.append(splat_W.uncertainty)
    sums = in_parallel(lambda array: zlib.crc32(array.data), arrays)
    shapes = [array.shape for array in arrays]
    named = f"solids {shapes} {sums} {n_sigma} {min_opacity} {solved}"
    return hashlib.sha256(named.encode()).hexdigest()[:32]


def splat_records(
    splat_W: GaussianSplat, min_opacity: float, n_sigma: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns splats as rows of 16 numbers, which `solid` describes.

    Returns:
        The rows, shape (N, 16), and the splats' ascending indices, shape (N,).
    """
    index = _opaque(splat_W, min_opacity)
    records = np.empty((len(index), 16))

    def store(rows: slice, block: np.ndarray) -> None:
        records[rows] = block

    _use_records(splat_W, index, n_sigma, store)
    return records, index


def _opaque(splat_W: GaussianSplat, min_opacity: float) -> np.ndarray:
    """Returns the indices of the splats with sufficient opacity."""
    opaque = np.flatnonzero(splat_W.opacities >= min_opacity)
    return opaque.astype(np.int32)


def _use_records(
    splat_W: GaussianSplat,
    index: np.ndarray,
    n_sigma: float,
    use: Callable[[slice, np.ndarray], None],
) -> None:
    """Unpacks blocks of splats, and calls `use(rows, records)` for each."""
    in_turn = np.arange(_BLOCK, dtype=np.int32)

    def work(share: slice) -> None:
        packed = np.empty((_BLOCK, PACKED), np.float32)
        memory = np.empty((_BLOCK, 16))
        for start in range(share.start, share.stop, _BLOCK):
            rows = slice(start, min(start + _BLOCK, share.stop))
            n = rows.stop - start
            _pack(splat_W, index[rows], in_turn[:n], packed)
            open_solids(packed[:n], float(n_sigma), memory[:n])
            use(rows, memory[:n])

    in_parallel(work, blocks(len(index), _SHARE))


def _pack(
    splat_W: GaussianSplat,
    index: np.ndarray,
    places: np.ndarray,
    packed: np.ndarray,
) -> None:
    """Packs some splats into given rows of an array."""
    uncertainty = splat_W.uncertainty
    pack_solids(
        index,
        splat_W.p_GK,
        splat_W.quaternions,
        splat_W.scales,
        _NONE if uncertainty is None else uncertainty,
        places,
        packed,
    )


def _boxes(
    splat_W: GaussianSplat, index: np.ndarray, n_sigma: float, solved: bool
) -> np.ndarray:
    """Returns the table of the splats' boxes that `hierarchy_of` takes."""
    table = np.empty((len(index), 8), np.float32)

    def bound(rows: slice, records: np.ndarray) -> None:
        boxes = np.empty((len(records), 7))
        fill_boxes(records, solved, boxes)
        round_outwards(boxes, table[rows])

    _use_records(splat_W, index, n_sigma, bound)
    return table


def _searched(
    splat_W: GaussianSplat,
    index: np.ndarray,
    hierarchy: BoundingVolumeHierarchy,
) -> dict[str, np.ndarray]:
    """Returns the data for queries: wide hierarchy, splats in leaf order."""
    wide, children = widen(hierarchy.nodes, hierarchy.links, LEAF_SIZE)
    # Sequential reads with scattered writes are faster than scattered reads
    # with sequential writes.
    places = np.empty(len(index), np.int32)
    places[hierarchy.order] = np.arange(len(index), dtype=np.int32)
    records = np.empty((len(index), PACKED), np.float32)

    def pack(rows: slice) -> None:
        _pack(splat_W, index[rows], places[rows], records)

    in_parallel(pack, blocks(len(index), _SHARE))
    order = index[hierarchy.order]
    return {
        "wide": wide,
        "children": children,
        "records": records,
        "order": order,
    }


def _holds(
    hierarchy: BoundingVolumeHierarchy,
    records: np.ndarray,
    n_sigma: float,
    solved: bool,
) -> bool:
    """Whether each box of the hierarchy contains all boxes below it."""

    def look(nodes: slice) -> bool:
        return are_enclosed(
            records,
            float(n_sigma),
            solved,
            hierarchy.nodes,
            hierarchy.links,
            nodes.start,
            nodes.stop,
        )

    return all(in_parallel(look, blocks(len(hierarchy.nodes), _SHARE)))
