"""Splats as solids in a hierarchy: what `SphereToEllipsoidField` searches."""

import hashlib
import zlib
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.threads import blocks, in_parallel
from remosplat_drake.oracle.kernels.solid_records import (
    are_enclosed,
    fill_boxes,
    fill_records,
    scatter_rows,
)
from remosplat_drake.splat.bvh import (
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
_NONE.flags.writeable = False  # As the arrays of a splat: one kernel for both.

_BLOCK = 1 << 12
"""Splats whose records stay in a core's cache until they are used."""

_SHARE = 1 << 16
"""Splats, or nodes, that a thread works on in a row."""


def prepare_solids(
    splat_W: GaussianSplat, n_sigma: float, min_opacity: float, solved: bool
) -> dict[str, np.ndarray]:
    """Sorts splats into a hierarchy, or finds it in the user's cache.

    Args:
        splat_W: The Gaussian splat.
        n_sigma: Semi-axes in standard deviations.
        min_opacity: Splats below this opacity are left out.
        solved: Whether closest points are converged.

    Returns:
        The `nodes` of a `BoundingVolumeHierarchy`, and in its leaf order the
        splats' `records`, see `splat_records`, and their indices, `order`.
    """
    index = _opaque(splat_W, min_opacity)
    if not is_kept(len(index)):
        hierarchy = hierarchy_of(_boxes(splat_W, index, n_sigma, solved))
        return _in_leaf_order(splat_W, index, n_sigma, hierarchy)
    key = _key(splat_W, n_sigma, min_opacity, solved)
    hierarchy = kept_hierarchy(key, len(index))
    if hierarchy is not None:
        prepared = _in_leaf_order(splat_W, index, n_sigma, hierarchy)
        if _holds(hierarchy, prepared["records"], solved):
            return prepared
    hierarchy = hierarchy_of(_boxes(splat_W, index, n_sigma, solved))
    keep_hierarchy(key, hierarchy)
    return _in_leaf_order(splat_W, index, n_sigma, hierarchy)


def _key(
    splat_W: GaussianSplat, n_sigma: float, min_opacity: float, solved: bool
) -> str:
    """Names what the boxes follow from: the shapes, not the colours.

    Checksums are enough, and faster than digests: a hierarchy of other splats,
    or of a program that made other boxes, is found by its boxes.
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
    """Packs splats into rows of 16 numbers, described in `nearest_splat`.

    The axes of a splat come in the order of falling semi-axes; a disc's
    normal stays last.

    Returns:
        The rows, shape (N, 16), and the splats' rising indices, shape (N,).
    """
    index = _opaque(splat_W, min_opacity)
    records = np.empty((len(index), 16))

    def store(rows: slice, block: np.ndarray) -> None:
        records[rows] = block

    _use_records(splat_W, index, n_sigma, store)
    return records, index


def _opaque(splat_W: GaussianSplat, min_opacity: float) -> np.ndarray:
    """The indices of splats that are opaque enough."""
    return np.flatnonzero(splat_W.opacities >= min_opacity)


def _use_records(
    splat_W: GaussianSplat,
    index: np.ndarray,
    n_sigma: float,
    use: Callable[[slice, np.ndarray], None],
) -> None:
    """Packs splats block by block, and hands them on: `use(rows, records)`."""
    uncertainty = splat_W.uncertainty

    def work(share: slice) -> None:
        memory = np.empty((_BLOCK, 16))
        for start in range(share.start, share.stop, _BLOCK):
            rows = slice(start, min(start + _BLOCK, share.stop))
            records = memory[: rows.stop - start]
            fill_records(
                index[rows],
                splat_W.p_GK,
                splat_W.quaternions,
                splat_W.scales,
                _NONE if uncertainty is None else uncertainty,
                float(n_sigma),
                records,
            )
            use(rows, records)

    in_parallel(work, blocks(len(index), _SHARE))


def _boxes(
    splat_W: GaussianSplat, index: np.ndarray, n_sigma: float, solved: bool
) -> np.ndarray:
    """The table of the splats' boxes for `hierarchy_of`."""
    table = np.empty((len(index), 8), np.float32)

    def bound(rows: slice, records: np.ndarray) -> None:
        boxes = np.empty((len(records), 7))
        fill_boxes(records, solved, boxes)
        round_outwards(boxes, table[rows])

    _use_records(splat_W, index, n_sigma, bound)
    return table


def _in_leaf_order(
    splat_W: GaussianSplat,
    index: np.ndarray,
    n_sigma: float,
    hierarchy: BoundingVolumeHierarchy,
) -> dict[str, np.ndarray]:
    # To read in the splats' order and write here and there is faster than the
    # other way round: a record fills two cache lines.
    places = np.empty(len(index), np.int32)
    places[hierarchy.order] = np.arange(len(index))
    records = np.empty((len(index), 16))

    def store(rows: slice, block: np.ndarray) -> None:
        scatter_rows(block, places[rows], records)

    _use_records(splat_W, index, n_sigma, store)
    order = index[hierarchy.order]
    return {"nodes": hierarchy.nodes, "records": records, "order": order}


def _holds(
    hierarchy: BoundingVolumeHierarchy, records: np.ndarray, solved: bool
) -> bool:
    """Whether every box holds what is below it."""

    def look(nodes: slice) -> bool:
        return are_enclosed(
            records,
            solved,
            hierarchy.nodes,
            hierarchy.links,
            nodes.start,
            nodes.stop,
        )

    return all(in_parallel(look, blocks(len(hierarchy.nodes), _SHARE)))
